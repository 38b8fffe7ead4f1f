#include "formats/mesh_text.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>

namespace overcast {
namespace {

bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}
bool isLineEnd(char c) {
  return c == '\n' || c == '\r';
}

void skipBlanks(TextScanner& scanner) {
  std::size_t i = 0;
  while (i < scanner.rest.size() && isBlank(scanner.rest[i])) ++i;
  scanner.rest.remove_prefix(i);
}

bool atComment(const TextScanner& scanner) {
  return scanner.comment != '\0' && !scanner.rest.empty() && scanner.rest[0] == scanner.comment;
}

std::string_view takeWord(TextScanner& scanner) {
  std::size_t i = 0;
  while (i < scanner.rest.size() && !isBlank(scanner.rest[i]) && !isLineEnd(scanner.rest[i])) ++i;
  const std::string_view word = scanner.rest.substr(0, i);
  scanner.rest.remove_prefix(i);
  return word;
}

}  // namespace

void skipLine(TextScanner& scanner) {
  std::size_t i = 0;
  while (i < scanner.rest.size() && !isLineEnd(scanner.rest[i])) ++i;
  if (i < scanner.rest.size()) {
    ++scanner.line;
    i += scanner.rest[i] == '\r' && i + 1 < scanner.rest.size() && scanner.rest[i + 1] == '\n' ? 2 : 1;
  }
  scanner.rest.remove_prefix(i);
}

std::string_view nextWordOnLine(TextScanner& scanner) {
  skipBlanks(scanner);
  if (scanner.rest.empty() || isLineEnd(scanner.rest[0]) || atComment(scanner)) return {};
  return takeWord(scanner);
}

std::string_view nextWord(TextScanner& scanner) {
  for (;;) {
    const std::string_view word = nextWordOnLine(scanner);
    if (!word.empty() || scanner.rest.empty()) return word;
    skipLine(scanner);
  }
}

std::optional<double> toDouble(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty() || code == std::errc::invalid_argument) return std::nullopt;
  // from_chars leaves the value alone when it is out of range; strtod tells overflow from underflow.
  if (code == std::errc::result_out_of_range) value = std::strtod(std::string(word).c_str(), nullptr);
  return value;
}

std::optional<std::int64_t> toInteger(std::string_view word) {
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code == std::errc() && end == word.data() + word.size()) return value;
  const std::optional<double> real = toDouble(word);
  if (!real || !(std::abs(*real) < 9e15) || *real != std::floor(*real)) return std::nullopt;
  return static_cast<std::int64_t>(*real);
}

std::string placeOf(const TextScanner& scanner) {
  return fmt::format("line {}", scanner.line);
}

std::string shown(std::string_view word) {
  std::string text(word.substr(0, 32));
  for (char& c : text) {
    if (c < 32 || c > 126) c = '?';
  }
  return text;
}

}  // namespace overcast
