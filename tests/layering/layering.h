// Layering: which file may include what (DESIGN 1), read from the text of the tree.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace overcast {

/// A broken rule and where. line is 1-based; 0 when the whole file is meant.
struct Violation {
  std::string file;  ///< relative to the root of the tree, with forward slashes
  int line = 0;
  std::string text;    ///< the offending line without white space around it
  std::string reason;  ///< one clause: what is allowed there
};

/// "file:line: text: reason"
std::string describe(const Violation& violation);

/// The rules applied to one source file. `file` is its path relative to the root; its room is its first folder (tests/reference is a room
/// of its own). The file need not exist: only its name and `text` are looked at.
std::vector<Violation> checkSource(const std::string& file, std::string_view text);

/// checkSource on every C++ and GLSL file below the rooms of `root`, in alphabetical order. `filesSeen`, when given, receives their number.
std::vector<Violation> checkTree(const std::filesystem::path& root, std::size_t* filesSeen = nullptr);

}  // namespace overcast
