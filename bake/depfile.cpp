#include "bake/depfile.h"

#include <set>

namespace overcast {
namespace {

/// The path as one word of a rule.
std::string escaped(const std::filesystem::path& path) {
  std::string word;
  std::size_t backslashes = 0;  // directly before the next character
  for (const char c : path.string()) {
    if (c == ' ' || c == '\t' || c == '#') word.append(backslashes + 1, '\\');
    if (c == ':') word += '\\';
    if (c == '$') word += '$';
    backslashes = c == '\\' ? backslashes + 1 : 0;
    word += c;
  }
  return word;
}

}  // namespace

Result<std::string> depfileText(const std::vector<Dependencies>& rules) {
  std::string text;
  std::set<std::filesystem::path> inputs;
  for (const Dependencies& rule : rules) {
    text += escaped(rule.target) + ":";
    for (const std::filesystem::path& input : rule.inputs) text += " \\\n  " + escaped(input);
    text += "\n";
    inputs.insert(rule.inputs.begin(), rule.inputs.end());
    inputs.insert(rule.target);
  }
  for (const std::filesystem::path& path : inputs)
    if (path.string().find_first_of("\n\r") != std::string::npos)
      return Error{path.string(), "", "has a line break in its name, which a depfile cannot express"};
  for (const Dependencies& rule : rules) inputs.erase(rule.target);
  for (const std::filesystem::path& input : inputs) text += escaped(input) + ":\n";
  return text;
}

}  // namespace overcast
