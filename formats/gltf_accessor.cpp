#include "formats/gltf_accessor.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

#include <tiny_gltf.h>

namespace overcast {
namespace {

/// An accessor without data costs nothing on disk, so its count needs a bound of its own.
constexpr std::uint64_t kMostZeros = std::uint64_t{1} << 24;

/// Elements within one buffer: element i starts at byte i * stride and lies wholly inside `bytes`.
struct View {
  std::span<const unsigned char> bytes;
  std::uint64_t stride = 0;
};

bool isComponentType(int type) {
  return type >= TINYGLTF_COMPONENT_TYPE_BYTE && type <= TINYGLTF_COMPONENT_TYPE_FLOAT && type != 5124;
}

std::uint64_t componentSize(int type) {
  return static_cast<std::uint64_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type)));
}

template <class T>
T load(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

template <class T>
double integer(const unsigned char* at, bool normalized) {
  const double value = static_cast<double>(load<T>(at));
  return normalized ? std::max(value / static_cast<double>(std::numeric_limits<T>::max()), -1.0) : value;
}

double component(const unsigned char* at, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return integer<std::int8_t>(at, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return integer<std::uint8_t>(at, normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return integer<std::int16_t>(at, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return integer<std::uint16_t>(at, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return integer<std::uint32_t>(at, normalized);
    default:
      return static_cast<double>(load<float>(at));
  }
}

/// `count` elements of `elementSize` bytes from `offset` in a buffer view. All sums are formed so that they cannot overflow.
Result<View> viewOf(const tinygltf::Model& model, int index, std::uint64_t offset, std::uint64_t count, std::uint64_t elementSize) {
  const auto fail = [&](const std::string& reason) { return Error{"", fmt::format("bufferViews/{}", index), reason}; };
  if (index < 0 || static_cast<std::size_t>(index) >= model.bufferViews.size()) return fail("does not exist");
  const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(index)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size())
    return fail(fmt::format("buffer {} does not exist", view.buffer));
  const auto& data = model.buffers[static_cast<std::size_t>(view.buffer)].data;
  if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
    return fail(fmt::format("bytes {} + {} are outside buffer {} of {} bytes", view.byteOffset, view.byteLength, view.buffer, data.size()));
  const std::uint64_t stride = view.byteStride != 0 ? view.byteStride : elementSize;
  if (stride < elementSize || stride > 255 + elementSize) return fail(fmt::format("byteStride {} does not fit", stride));
  const std::uint64_t available = offset <= view.byteLength ? view.byteLength - offset : 0;
  if (count > 0 && (available < elementSize || count - 1 > (available - elementSize) / stride))
    return fail(fmt::format("{} elements of {} bytes from {} do not fit into its {} bytes", count, elementSize, offset, view.byteLength));
  return View{std::span(data).subspan(view.byteOffset, view.byteLength).subspan(std::min<std::uint64_t>(offset, view.byteLength)), stride};
}

void copyElement(const tinygltf::Accessor& accessor, const View& view, std::uint64_t from, std::uint64_t to, std::size_t components,
                 std::vector<double>& out) {
  const std::uint64_t size = componentSize(accessor.componentType);
  for (std::size_t c = 0; c < components; ++c)
    out[to * components + c] = component(view.bytes.data() + from * view.stride + c * size, accessor.componentType, accessor.normalized);
}

Result<Done> applySparse(const tinygltf::Model& model, const tinygltf::Accessor& accessor, std::size_t components,
                         std::vector<double>& out) {
  const auto& sparse = accessor.sparse;
  if (sparse.count < 0 || static_cast<std::uint64_t>(sparse.count) > accessor.count)
    return Error{"", "sparse/count", fmt::format("{} is more than the accessor's {}", sparse.count, accessor.count)};
  if (sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0) return Error{"", "sparse", "has a negative byteOffset"};
  const int type = sparse.indices.componentType;
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    return Error{"", "sparse/indices/componentType", fmt::format("{} is not an unsigned integer type", type)};
  const auto count = static_cast<std::uint64_t>(sparse.count);
  auto indices =
      viewOf(model, sparse.indices.bufferView, static_cast<std::uint64_t>(sparse.indices.byteOffset), count, componentSize(type));
  if (!indices) return indices.error();
  auto values = viewOf(model, sparse.values.bufferView, static_cast<std::uint64_t>(sparse.values.byteOffset), count,
                       componentSize(accessor.componentType) * components);
  if (!values) return values.error();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto target = static_cast<std::uint64_t>(component(indices.value().bytes.data() + i * indices.value().stride, type, false));
    if (target >= accessor.count) return Error{"", "sparse/indices", fmt::format("{} is outside the {} elements", target, accessor.count)};
    copyElement(accessor, values.value(), i, target, components, out);
  }
  return Done{};
}

Result<std::vector<double>> numbersOf(const tinygltf::Model& model, const tinygltf::Accessor& accessor, int components) {
  if (!isComponentType(accessor.componentType))
    return Error{"", "componentType", fmt::format("{} is not a glTF 2.0 component type", accessor.componentType)};
  const int has = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
  if (has != components || accessor.type > TINYGLTF_TYPE_SCALAR || (accessor.type > 32 && accessor.type < TINYGLTF_TYPE_SCALAR))
    return Error{"", "type", fmt::format("has {} components where {} are needed", has, components)};
  const auto width = static_cast<std::size_t>(components);
  if (accessor.count > std::numeric_limits<std::uint32_t>::max())
    return Error{"", "count", fmt::format("{} is more than glTF indices can address", accessor.count)};
  if (accessor.bufferView < 0 && accessor.count > kMostZeros)
    return Error{"", "count", fmt::format("{} elements without data are more than {}", accessor.count, kMostZeros)};
  std::optional<View> view;
  if (accessor.bufferView >= 0) {
    auto checked = viewOf(model, accessor.bufferView, accessor.byteOffset, accessor.count, componentSize(accessor.componentType) * width);
    if (!checked) return checked.error();
    view = checked.value();
  }
  std::vector<double> out(accessor.count * width, 0.0);
  for (std::uint64_t i = 0; view && i < accessor.count; ++i) copyElement(accessor, *view, i, i, width, out);
  if (accessor.sparse.isSparse) {
    auto applied = applySparse(model, accessor, width, out);
    if (!applied) return applied.error();
  }
  return out;
}

}  // namespace

Result<std::vector<double>> readNumbers(const tinygltf::Model& model, int accessor, int components) {
  const std::string place = fmt::format("accessors/{}", accessor);
  if (accessor < 0 || static_cast<std::size_t>(accessor) >= model.accessors.size()) return Error{"", place, "does not exist"};
  auto numbers = numbersOf(model, model.accessors[static_cast<std::size_t>(accessor)], components);
  if (numbers) return numbers;
  return Error{"", place + "/" + numbers.error().place, numbers.error().reason};
}

Result<std::vector<std::uint32_t>> readIndices(const tinygltf::Model& model, int accessor) {
  auto numbers = readNumbers(model, accessor, 1);
  if (!numbers) return numbers.error();
  const tinygltf::Accessor& source = model.accessors[static_cast<std::size_t>(accessor)];
  const int type = source.componentType;
  const bool isUnsigned = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                          type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  if (!isUnsigned || source.normalized)
    return Error{"", fmt::format("accessors/{}", accessor), "does not hold plain unsigned integers, as indices must"};
  std::vector<std::uint32_t> indices(numbers.value().size());
  std::transform(numbers.value().begin(), numbers.value().end(), indices.begin(), [](double v) { return static_cast<std::uint32_t>(v); });
  return indices;
}

}  // namespace overcast
