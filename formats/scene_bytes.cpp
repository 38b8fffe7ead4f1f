#include "formats/scene_bytes.h"

#include <type_traits>

#include "formats/packing.h"
#include "formats/scene_check.h"

namespace overcast {
namespace {

/// Both archives walk the same fields in the same order, so that they cannot disagree. Types without fields are plain bytes without
/// padding.
template <class Archive>
void fields(Archive& archive, Mesh& mesh) {
  archive(mesh.name, mesh.positions, mesh.normals, mesh.triangles, mesh.parts);
}

template <class Archive>
void fields(Archive& archive, Material& material) {
  archive(material.name, material.baseColour);
}

template <class Archive>
void fields(Archive& archive, Camera& camera) {
  archive(camera.name, camera.verticalFieldOfView, camera.nearPlane);
}

template <class Archive>
void fields(Archive& archive, Primitive& primitive) {
  archive(primitive.shape, primitive.centre, primitive.rotation, primitive.halfExtents);
}

template <class Archive>
void fields(Archive& archive, MeasuredError& error) {
  archive(error.max, error.rms, error.signErrors, error.samples, error.seed, error.p99, error.surfaceRms, error.skyRmse, error.method);
}

template <class Archive>
void fields(Archive& archive, Occluder& occluder) {
  archive(occluder.representation, occluder.uri, occluder.contentHash, occluder.bytes, occluder.primitive, occluder.bounds,
          occluder.influenceRadius, occluder.lipschitz, occluder.bits, occluder.signMethod, occluder.error, occluder.source,
          occluder.settingsHash);
}

template <class Archive>
void fields(Archive& archive, Node& node) {
  archive(node.name, node.parent, node.children, node.matrix, node.translation, node.rotation, node.scale, node.mesh, node.camera,
          node.occluder);
}

template <class Archive>
void fields(Archive& archive, AnimationChannel& channel) {
  archive(channel.node, channel.property, channel.interpolation, channel.times, channel.values);
}

template <class Archive>
void fields(Archive& archive, Animation& animation) {
  archive(animation.name, animation.channels);
}

template <class Archive>
void fields(Archive& archive, GlobalVolume& volume) {
  archive(volume.bounds, volume.resolution);
}

template <class Archive>
void fields(Archive& archive, Estimator& estimator) {
  archive(estimator.name, estimator.taps, estimator.k, estimator.skyWeight, estimator.fitError);
}

template <class Archive>
void fields(Archive& archive, Lighting& lighting) {
  archive(lighting.skyColour, lighting.up, lighting.sun, lighting.areaLights, lighting.globalVolume, lighting.estimator, lighting.exposure);
}

template <class Archive>
void fields(Archive& archive, Scene& scene) {
  archive(scene.name, scene.meshes, scene.materials, scene.cameras, scene.nodes, scene.animations, scene.lighting, scene.notes);
}

/// Archive that appends everything it meets.
struct SceneWriter {
  std::vector<std::byte> bytes;

  template <class... T>
  void operator()(T&... values) {
    (put(values), ...);
  }

  template <class T>
  void put(T& value) {
    if constexpr (requires { fields(*this, value); }) {
      fields(*this, value);
    } else {
      pack(bytes, value);
    }
  }

  void put(std::string& text) { packText(bytes, text); }

  template <class T>
  void put(std::optional<T>& value) {
    pack(bytes, static_cast<std::uint8_t>(value.has_value()));
    if (value) put(*value);
  }

  template <class T>
  void put(std::vector<T>& values) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      packAll(bytes, std::span<const T>(values));
    } else {
      pack(bytes, static_cast<std::uint64_t>(values.size()));
      for (T& value : values) put(value);
    }
  }
};

/// Archive that fills everything it meets.
struct SceneReader {
  Unpacker rest;

  template <class... T>
  void operator()(T&... values) {
    (take(values), ...);
  }

  template <class T>
  void take(T& value) {
    if constexpr (requires { fields(*this, value); }) {
      fields(*this, value);
    } else {
      value = rest.one<T>();
    }
  }

  void take(std::string& text) { text = rest.text(); }

  template <class T>
  void take(std::optional<T>& value) {
    value.reset();
    if (rest.one<std::uint8_t>() != 0) take(value.emplace());
  }

  template <class T>
  void take(std::vector<T>& values) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      values = rest.all<T>();
    } else {
      const auto size = rest.one<std::uint64_t>();
      while (values.size() < size && rest.good()) take(values.emplace_back());
    }
  }
};

}  // namespace

std::vector<std::byte> packScene(const Scene& scene) {
  SceneWriter writer;
  fields(writer, const_cast<Scene&>(scene));  // the writer only reads; one list of fields serves both directions
  return std::move(writer.bytes);
}

std::optional<Scene> unpackScene(std::span<const std::byte> bytes) {
  SceneReader reader{Unpacker(bytes)};
  Scene scene;
  fields(reader, scene);
  if (!reader.rest.atEnd() || !brokenInvariant(scene).empty()) return std::nullopt;
  return scene;
}

}  // namespace overcast
