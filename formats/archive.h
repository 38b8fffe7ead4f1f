// Archive: structs as bytes and back, for what only this program reads again: what a sandboxed parser hands to its parent, and the bake
// cache. A struct takes part through `template <class Archive> void fields(Archive& archive, Struct& value)` in namespace overcast, which
// names its members once; both directions walk them in the same order, so that they cannot disagree. Types without fields are plain bytes
// without padding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/packing.h"

namespace overcast {

/// Archive that appends everything it meets.
struct ArchiveWriter {
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

/// Archive that fills everything it meets; what is missing becomes empty, and `rest` says so.
struct ArchiveReader {
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
      values.clear();
      while (values.size() < size && rest.good()) take(values.emplace_back());
    }
  }
};

/// `value` as bytes.
template <class T>
std::vector<std::byte> archived(const T& value) {
  ArchiveWriter writer;
  writer.put(const_cast<T&>(value));  // the writer only reads; one list of fields serves both directions
  return std::move(writer.bytes);
}

/// The value that was archived; nothing when the bytes are cut short or too long.
template <class T>
std::optional<T> unarchived(std::span<const std::byte> bytes) {
  ArchiveReader reader{Unpacker(bytes)};
  std::optional<T> value(std::in_place);
  reader.take(*value);
  if (!reader.rest.atEnd()) value.reset();
  return value;
}

}  // namespace overcast
