// glTF animations of node transforms (glTF 2.0, 3.11).
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <tiny_gltf.h>

#include "formats/gltf_accessor.h"
#include "formats/gltf_reader.h"

namespace overcast {
namespace {

std::optional<AnimatedProperty> propertyOf(const std::string& path) {
  if (path == "translation") return AnimatedProperty::translation;
  if (path == "rotation") return AnimatedProperty::rotation;
  if (path == "scale") return AnimatedProperty::scale;
  return std::nullopt;
}

std::optional<Interpolation> interpolationOf(const std::string& name) {
  if (name == "STEP") return Interpolation::step;
  if (name == "LINEAR") return Interpolation::linear;
  if (name == "CUBICSPLINE") return Interpolation::cubicSpline;
  return std::nullopt;
}

bool areTimes(const std::vector<double>& times) {
  for (std::size_t i = 0; i < times.size(); ++i)
    if (!std::isfinite(times[i]) || times[i] < 0.0 || (i > 0 && !(times[i] > times[i - 1]))) return false;
  return !times.empty();
}

bool areFinite(const std::vector<double>& values) {
  for (const double v : values)
    if (!std::isfinite(v)) return false;
  return true;
}

/// Rotation keys to unit length; false when one has no direction. Tangents of cubic splines are no rotations and stay.
bool normaliseRotations(AnimationChannel& channel) {
  const bool cubic = channel.interpolation == Interpolation::cubicSpline;
  for (std::size_t i = cubic ? 1 : 0; i < channel.values.size(); i += cubic ? 3 : 1) {
    glm::dvec4& q = channel.values[i];
    const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    if (!(length > 0.0) || !std::isfinite(length)) return false;
    if (std::abs(length - 1.0) > 1e-5) q /= length;
  }
  return true;
}

/// Fills times and values; nothing when they are unusable, with the reason in the tally.
Result<bool> readKeys(const tinygltf::Model& model, const tinygltf::AnimationSampler& sampler, AnimationChannel& channel, Tally& tally) {
  const int width = channel.property == AnimatedProperty::rotation ? 4 : 3;
  auto times = readNumbers(model, sampler.input, 1);
  if (!times) return times.error();
  auto values = readNumbers(model, sampler.output, width);
  if (!values) return values.error();
  const std::size_t perKey = channel.interpolation == Interpolation::cubicSpline ? 3 : 1;
  const std::size_t elements = values.value().size() / static_cast<std::size_t>(width);
  channel.times = std::move(times).value();
  if (!areTimes(channel.times)) {
    ++tally["animation channels have times that do not increase from zero or more; these were left out"];
    return false;
  }
  if (elements != channel.times.size() * perKey)
    return Error{"", "output", fmt::format("has {} elements for {} keys", elements, channel.times.size())};
  for (std::size_t i = 0; i < elements; ++i) {
    glm::dvec4 value(0.0);
    for (int c = 0; c < width; ++c) value[c] = values.value()[i * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)];
    channel.values.push_back(value);
  }
  if (areFinite(values.value()) && (channel.property != AnimatedProperty::rotation || normaliseRotations(channel))) return true;
  ++tally["animation channels hold values that are no numbers or no rotations; these were left out"];
  return false;
}

/// The channel, or nothing when it moves nothing that we keep.
Result<std::optional<AnimationChannel>> readChannel(const tinygltf::Model& model, const tinygltf::Animation& animation,
                                                    const tinygltf::AnimationChannel& source, const std::vector<int>& newIndex,
                                                    Tally& tally) {
  if (source.target_node >= static_cast<int>(newIndex.size()))
    return Error{"", "target/node", fmt::format("{} does not exist", source.target_node)};
  const auto property = propertyOf(source.target_path);
  if (source.target_node < 0 || !property) {
    ++tally["animation channels target something else than a node's transform; these were left out"];
    return std::optional<AnimationChannel>{};
  }
  if (source.sampler < 0 || static_cast<std::size_t>(source.sampler) >= animation.samplers.size())
    return Error{"", "sampler", fmt::format("{} does not exist", source.sampler)};
  const tinygltf::AnimationSampler& sampler = animation.samplers[static_cast<std::size_t>(source.sampler)];
  const auto interpolation = interpolationOf(sampler.interpolation);
  if (!interpolation) return Error{"", "sampler", fmt::format("interpolation '{}' is not glTF 2.0", sampler.interpolation)};
  AnimationChannel channel{newIndex[static_cast<std::size_t>(source.target_node)], *property, *interpolation, {}, {}};
  auto usable = readKeys(model, sampler, channel, tally);
  if (!usable) return usable.error();
  if (!usable.value() || channel.node < 0) return std::optional<AnimationChannel>{};
  return std::optional(std::move(channel));
}

}  // namespace

Result<std::vector<Animation>> readGltfAnimations(const tinygltf::Model& model, const std::vector<int>& newIndex,
                                                  const std::vector<Node>& nodes, Tally& tally) {
  std::vector<Animation> animations;
  for (std::size_t a = 0; a < model.animations.size(); ++a) {
    const tinygltf::Animation& source = model.animations[a];
    Animation animation{source.name, {}};
    std::set<std::pair<int, AnimatedProperty>> targets;
    for (std::size_t c = 0; c < source.channels.size(); ++c) {
      auto channel = readChannel(model, source, source.channels[c], newIndex, tally);
      if (!channel) {
        const Error& error = channel.error();
        return Error{"", fmt::format("animations/{}/channels/{}", a, c), error.place + ": " + error.reason};
      }
      if (!channel.value()) continue;
      AnimationChannel& read = *channel.value();
      if (nodes[static_cast<std::size_t>(read.node)].matrix) {
        ++tally["animation channels target a node that has a matrix; these were left out"];
      } else if (!targets.insert({read.node, read.property}).second) {
        ++tally["animation channels target a property twice; these were left out"];
      } else {
        animation.channels.push_back(std::move(read));
      }
    }
    if (!animation.channels.empty()) animations.push_back(std::move(animation));
  }
  return animations;
}

}  // namespace overcast
