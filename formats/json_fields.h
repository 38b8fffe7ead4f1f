// JSON fields: reading a JSON object field by field, each checked and named in its error. Internal to formats' .cpp files (it brings in
// nlohmann-json); what the documents mean is in formats/schema/.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec4.hpp>
#include <nlohmann/json.hpp>

#include "formats/mesh.h"
#include "formats/result.h"

namespace overcast {

using Json = nlohmann::ordered_json;

inline constexpr double kLargestNumber = std::numeric_limits<double>::max();
inline constexpr double kSmallestNumber = std::numeric_limits<double>::min();

/// One object being read. The first thing that is wrong is remembered, so that a parser reads as a list of fields.
class Fields {
 public:
  Fields(const Json& object, std::string place, std::optional<Error>& error) : object_(object), place_(std::move(place)), error_(error) {
    if (!object_.is_object()) fail("", "is not an object");
  }

  bool has(const char* key) const { return object_.is_object() && object_.contains(key); }

  Fields child(const char* key) { return {find(key), place_ + "/" + key, error_}; }
  Fields element(const char* key, std::size_t i) { return {find(key).at(i), place_ + "/" + key + "/" + std::to_string(i), error_}; }

  std::size_t arraySize(const char* key) {
    const Json& value = find(key);
    if (!value.is_array()) fail(key, "is not an array");
    return value.is_array() ? value.size() : 0;
  }

  template <class T>
  void number(const char* key, T& out, double low, double high) {
    const Json& value = find(key);
    if (checked(value, key, low, high)) out = static_cast<T>(value.get<double>());
  }

  template <class T>
  void integer(const char* key, T& out, T low, T high) {
    const Json& value = find(key);
    const bool fits = value.is_number_unsigned() && value.get<std::uint64_t>() <= static_cast<std::uint64_t>(high) &&
                      value.get<std::uint64_t>() >= static_cast<std::uint64_t>(low);
    if (!fits) return fail(key, fmt::format("is not an integer from {} to {}", low, high));
    out = value.get<T>();
  }

  template <class Vector>
  void vector(const char* key, Vector& out, double low, double high) {
    const Json& value = find(key);
    constexpr int count = Vector::length();
    if (!value.is_array() || value.size() != count) return fail(key, fmt::format("is not an array of {} numbers", count));
    for (int i = 0; i < count; ++i) {
      const Json& entry = value.at(static_cast<std::size_t>(i));
      if (!checked(entry, key, low, high)) return;
      out[i] = static_cast<typename Vector::value_type>(entry.get<double>());
    }
  }

  /// An array of `count` numbers.
  template <class T>
  void numbers(const char* key, std::vector<T>& out, std::size_t count, double low, double high) {
    const Json& value = find(key);
    if (!value.is_array() || value.size() != count) return fail(key, fmt::format("is not an array of {} numbers", count));
    out.clear();
    for (const Json& entry : value) {
      if (!checked(entry, key, low, high)) return;
      out.push_back(static_cast<T>(entry.get<double>()));
    }
  }

  void direction(const char* key, glm::vec3& out) {
    glm::vec3 read = out;
    vector(key, read, -2.0, 2.0);
    const double length = std::sqrt(double{read.x} * read.x + double{read.y} * read.y + double{read.z} * read.z);
    if (std::abs(length - 1.0) > 1e-3) return fail(key, fmt::format("is not a unit vector (its length is {:.6g})", length));
    out = read;
  }

  /// x, y, z, w; made exactly unit where only its digits were cut short.
  void rotation(const char* key, glm::dquat& out) {
    glm::dvec4 xyzw(0.0, 0.0, 0.0, 1.0);
    vector(key, xyzw, -2.0, 2.0);
    const double length = glm::length(xyzw);
    if (std::abs(length - 1.0) > 1e-6) return fail(key, fmt::format("is not a unit quaternion (its length is {:.9g})", length));
    if (std::abs(length - 1.0) > 1e-14) xyzw /= length;
    out = glm::dquat(xyzw.w, xyzw.x, xyzw.y, xyzw.z);
  }

  void flag(const char* key, bool& out) {
    const Json& value = find(key);
    if (!value.is_boolean()) return fail(key, "is neither true nor false");
    out = value.get<bool>();
  }

  void text(const char* key, std::string& out, bool mayBeEmpty) {
    const Json& value = find(key);
    if (!value.is_string()) return fail(key, "is not a string");
    out = value.get<std::string>();
    if (out.empty() && !mayBeEmpty) fail(key, "is empty");
  }

  void box(const char* key, Box& out) {
    Fields fields = child(key);
    fields.vector("min", out.min, -kLargestNumber, kLargestNumber);
    fields.vector("max", out.max, -kLargestNumber, kLargestNumber);
    for (int i = 0; i < 3; ++i)
      if (!(out.min[i] <= out.max[i])) fields.fail("min", fmt::format("{} is above max {}", out.min[i], out.max[i]));
  }

  void version(int newest) {
    int version = 1;
    integer("version", version, 1, std::numeric_limits<int>::max());
    if (version > newest) fail("version", fmt::format("{} is newer than {}, the newest this program knows", version, newest));
  }

  void fail(const std::string& key, std::string reason) {
    if (!error_) error_ = Error{"", key.empty() ? place_ : place_ + "/" + key, std::move(reason)};
  }

 private:
  const Json& find(const char* key) {
    static const Json nothing;
    if (has(key)) return object_.at(key);
    fail(key, "is missing");
    return nothing;
  }

  bool checked(const Json& value, const char* key, double low, double high) {
    const double number = value.is_number() ? value.get<double>() : 0.0;
    const bool fits = value.is_number() && number >= low && number <= high;
    if (!fits) fail(key, value.is_number() ? fmt::format("{} is outside {:.6g} to {:.6g}", number, low, high) : "is not a number");
    return fits;
  }

  const Json& object_;
  std::string place_;
  std::optional<Error>& error_;
};

template <class T, class Read>
Result<T> parseObject(std::string_view json, const std::string& place, Read read) {
  const Json document = Json::parse(json, nullptr, false);
  std::optional<Error> error;
  Fields fields(document, place, error);
  T value;
  if (!error) read(fields, value);
  if (error) return *error;
  return value;
}

inline Json arrayOf(const glm::dvec3& v) {
  return Json::array({v.x, v.y, v.z});
}

/// On one line unless `indent` is 0 or more. Bytes that are no UTF-8 (names from old mesh files) become U+FFFD: JSON text has no other way
/// to hold them.
inline std::string dumpJson(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace overcast
