// Result<T>: what every function returns whose failure a user can cause (a bad file, a full disk, a missing device).
// Errors that only a programmer can cause are not Results: they stop at once through OVERCAST_REQUIRE with both values printed.
#pragma once

#include <cstdlib>
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>

namespace overcast {

/// A failure that a user can cause and mend.
struct Error {
  std::string file;    ///< the file at fault as the user named it; empty when no file is involved
  std::string place;   ///< where in the file ("line 12", "meshes/3/primitives/0"); may be empty
  std::string reason;  ///< one clause without a full stop, lower case, no line breaks
};

/// The one line a user sees: "file: place: reason", leaving out what is empty. Never holds a line break.
std::string message(const Error& error);

/// Either a value or an Error. Ask ok() before value(); asking for the wrong one stops the program.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

/// The value of a Result<Done>: the work is done and there is nothing to hand back.
struct Done {};

/// Stops the program with the place and a message: for broken invariants, never for user input.
[[noreturn]] void stop(const char* file, int line, const std::string& what);

}  // namespace overcast

/// Stops with the message when `condition` is false: OVERCAST_REQUIRE(a == b, "a is {}, b is {}", a, b).
#define OVERCAST_REQUIRE(condition, ...)                                              \
  do {                                                                                \
    if (!(condition)) ::overcast::stop(__FILE__, __LINE__, fmt::format(__VA_ARGS__)); \
  } while (false)
