// Packing: plain values in and out of byte buffers, for what only this program reads again (formats/archive.h, formats/sandbox.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace overcast {

template <class T>
void pack(std::vector<std::byte>& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof(T));
}

template <class T>
void packAll(std::vector<std::byte>& bytes, std::span<const T> values) {
  static_assert(std::is_trivially_copyable_v<T>);
  pack(bytes, static_cast<std::uint64_t>(values.size()));
  const auto raw = std::as_bytes(values);
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

inline void packText(std::vector<std::byte>& bytes, const std::string& text) {
  packAll(bytes, std::span<const char>(text));
}

/// Takes values out in the order they went in. Running past the end makes every later value empty and good() false: the child that filled
/// the buffer may have been corrupted by the file it parsed.
class Unpacker {
 public:
  explicit Unpacker(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T one() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    if (take(sizeof(T))) {
      std::memcpy(&value, rest_.data(), sizeof(T));
      rest_ = rest_.subspan(sizeof(T));
    }
    return value;
  }

  template <class T>
  std::vector<T> all() {
    const auto count = one<std::uint64_t>();
    if (!good_ || count > rest_.size() / sizeof(T)) {
      good_ = false;
      return {};
    }
    std::vector<T> values(count);
    if (count > 0) std::memcpy(values.data(), rest_.data(), count * sizeof(T));
    rest_ = rest_.subspan(count * sizeof(T));
    return values;
  }

  std::string text() {
    const auto letters = all<char>();
    return {letters.begin(), letters.end()};
  }

  bool good() const { return good_; }
  bool atEnd() const { return good_ && rest_.empty(); }

 private:
  bool take(std::size_t count) {
    good_ = good_ && count <= rest_.size();
    return good_;
  }

  std::span<const std::byte> rest_;
  bool good_ = true;
};

}  // namespace overcast
