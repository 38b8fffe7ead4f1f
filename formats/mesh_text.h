// A scanner over the words and lines of text mesh formats. Internal to formats. Lines end with \n, \r\n or \r.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "formats/result.h"

namespace overcast {

/// Where a scanner is: `rest` is the text not yet read.
struct TextScanner {
  std::string_view rest;
  std::uint64_t line = 1;  ///< of the next character, counted from 1
  char comment = '\0';     ///< starts a comment that ends with the line; '\0': none
};

/// Skips blanks, line ends and comments; the next word, or an empty view at the end of the text.
std::string_view nextWord(TextScanner& scanner);
/// The next word of this line, or an empty view when the line (or its part before a comment) has no more.
std::string_view nextWordOnLine(TextScanner& scanner);
/// Moves behind the end of this line.
void skipLine(TextScanner& scanner);

/// The number that a word spells ("1", "+1.5e3", "nan", "inf"); overflow gives an infinity. Empty when it spells none.
std::optional<double> toDouble(std::string_view word);
/// The integer that a word spells; "3.0" counts as 3, as some writers have it.
std::optional<std::int64_t> toInteger(std::string_view word);

/// "line 12" for Error::place.
std::string placeOf(const TextScanner& scanner);
/// A word for a message: shortened, without unprintable characters.
std::string shown(std::string_view word);

}  // namespace overcast
