#include "tests/layering/layering.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace overcast {
namespace {

constexpr int kMaxLines = 500;
constexpr std::array<std::string_view, 5> kRooms = {"formats", "bake", "runtime", "data", "tests"};
constexpr std::array<std::string_view, 8> kExtensions = {".cpp", ".h", ".inl", ".glsl", ".comp", ".vert", ".frag", ".geom"};

// What a room may include from the tree: prefixes of paths.
struct RoomRule {
  std::string_view room;
  std::vector<std::string_view> mayInclude;
};

const std::vector<RoomRule>& roomRules() {
  static const std::vector<RoomRule> rules = {
      // Truth shares no code with what it checks: of formats it takes the plain types.
      {"tests/reference/",
       {"tests/reference/", "formats/heightfield.h", "formats/mesh.h", "formats/volume.h", "formats/image.h", "formats/scene.h",
        "formats/lighting.h", "formats/occluder.h", "formats/result.h"}},
      {"tests/", {"tests/", "formats/", "bake/", "runtime/", "data/"}},
      {"formats/", {"formats/"}},
      {"bake/", {"bake/", "formats/"}},
      {"runtime/", {"runtime/", "formats/"}},
      {"data/", {"data/", "formats/"}},
  };
  return rules;
}

// A library that stays behind .cpp files of the rooms it was chosen for (DESIGN 7). Tests may look through any library's eyes.
struct LibraryRule {
  std::string_view name;
  std::vector<std::string_view> headers;  // prefixes
  std::vector<std::string_view> rooms;
};

const std::vector<LibraryRule>& libraryRules() {
  static const std::vector<LibraryRule> rules = {
      {"OpenVDB", {"openvdb/", "nanovdb/"}, {"formats/", "tests/"}},
      {"OpenMesh", {"OpenMesh/"}, {"formats/", "bake/", "tests/"}},
      {"tinygltf", {"tiny_gltf", "tinygltf"}, {"formats/", "tests/"}},
      {"OpenEXR", {"OpenEXR/", "Imf", "Imath/"}, {"formats/", "tests/"}},
      {"libpng", {"png.h", "libpng"}, {"formats/", "tests/"}},
      {"CGAL", {"CGAL/"}, {"bake/", "tests/"}},
      {"Embree", {"embree3/", "embree4/"}, {"bake/", "tests/"}},
      {"glslang", {"glslang/", "SPIRV/", "StandAlone/"}, {"runtime/", "tests/"}},
  };
  return rules;
}

bool startsWithAny(std::string_view text, const std::vector<std::string_view>& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(), [&](std::string_view prefix) { return text.starts_with(prefix); });
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// The path between the quotes or angle brackets of an #include line.
std::optional<std::string_view> includedPath(std::string_view line) {
  line = trimmed(line);
  if (!line.starts_with('#')) return std::nullopt;
  line = trimmed(line.substr(1));
  if (!line.starts_with("include")) return std::nullopt;
  const auto open = line.find_first_of("\"<");
  if (open == std::string_view::npos) return std::nullopt;
  const auto close = line.find_first_of("\">", open + 1);
  if (close == std::string_view::npos) return std::nullopt;
  return line.substr(open + 1, close - open - 1);
}

bool inTree(std::string_view included) {
  return std::any_of(kRooms.begin(), kRooms.end(),
                     [&](std::string_view room) { return included.starts_with(room) && included.substr(room.size()).starts_with('/'); });
}

// The reason why `file` may not include `included`, or nothing.
std::optional<std::string> forbidden(std::string_view file, std::string_view included) {
  if (included.find("..") != std::string_view::npos) return "includes name the whole path from the root, without '..'";
  if (inTree(included)) {
    for (const RoomRule& rule : roomRules()) {
      if (!file.starts_with(rule.room)) continue;
      if (startsWithAny(included, rule.mayInclude)) return std::nullopt;
      return fmt::format("{} may include {} only", rule.room, fmt::join(rule.mayInclude, ", "));
    }
    return std::nullopt;
  }
  for (const LibraryRule& rule : libraryRules()) {
    if (!startsWithAny(included, rule.headers)) continue;
    if (!startsWithAny(file, rule.rooms)) return fmt::format("{} belongs in {} only", rule.name, fmt::join(rule.rooms, ", "));
    if (!file.ends_with(".cpp")) return fmt::format("{} stays behind .cpp files", rule.name);
  }
  return std::nullopt;
}

// C++ and GLSL read the headers and shaders of a pass: those may reach other passes and formats/shared, nothing else of the tree.
// Shaders of tests may reach tests, too.
std::optional<std::string> forbiddenInShader(std::string_view file, std::string_view included) {
  if (file.ends_with(".cpp") || file.ends_with(".h") || file.ends_with(".inl")) return std::nullopt;
  if (!inTree(included) || included.starts_with("runtime/") || included.starts_with("formats/shared/")) return std::nullopt;
  if (file.starts_with("tests/") && included.starts_with("tests/")) return std::nullopt;
  return "shaders may include runtime/ and formats/shared/ only";
}

bool isSource(const std::filesystem::path& path) {
  return std::find(kExtensions.begin(), kExtensions.end(), path.extension().string()) != kExtensions.end();
}

}  // namespace

std::string describe(const Violation& violation) {
  return fmt::format("{}:{}: {}: {}", violation.file, violation.line, violation.text, violation.reason);
}

std::vector<Violation> checkSource(const std::string& file, std::string_view text) {
  std::vector<Violation> violations;
  int lines = 0;
  while (!text.empty()) {
    const auto end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++lines;
    const auto included = includedPath(line);
    if (!included) continue;
    auto reason = forbidden(file, *included);
    if (!reason) reason = forbiddenInShader(file, *included);
    if (reason) violations.push_back({file, lines, std::string(trimmed(line)), *reason});
  }
  if (lines > kMaxLines) violations.push_back({file, 0, fmt::format("{} lines", lines), fmt::format("at most {} lines", kMaxLines)});
  return violations;
}

std::vector<Violation> checkTree(const std::filesystem::path& root, std::size_t* filesSeen) {
  std::vector<std::filesystem::path> files;
  for (std::string_view room : kRooms) {
    if (!std::filesystem::is_directory(root / room)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / room)) {
      if (entry.is_regular_file() && isSource(entry.path())) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  if (filesSeen != nullptr) *filesSeen = files.size();
  std::vector<Violation> violations;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const auto found = checkSource(file.lexically_relative(root).generic_string(), text);
    violations.insert(violations.end(), found.begin(), found.end());
  }
  return violations;
}

}  // namespace overcast
