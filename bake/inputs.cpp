#include "bake/inputs.h"

#include <algorithm>
#include <map>
#include <system_error>

#include "formats/files.h"
#include "formats/mesh.h"
#include "formats/scene.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kLargestList = std::uint64_t{256} << 20;

/// Absolute and without links, as far as it exists.
fs::path realPath(const fs::path& path) {
  std::error_code code;
  const fs::path real = fs::weakly_canonical(path, code);
  return code ? path : real;
}

/// Appends what lies in `folder`.
Result<Done> addFolder(const fs::path& folder, const fs::path& outputFolder, std::vector<InputFile>& files) {
  const std::size_t first = files.size();
  const fs::path output = realPath(outputFolder);
  std::error_code code;
  fs::recursive_directory_iterator at(folder, code);
  for (const fs::recursive_directory_iterator end; !code && at != end; at.increment(code)) {
    std::error_code broken;  // a link that leads nowhere is no file
    if (at->is_directory(broken) && !outputFolder.empty() && realPath(at->path()) == output) at.disable_recursion_pending();
    if (!at->is_regular_file(broken) || !(isMeshFile(at->path()) || isSceneFile(at->path()))) continue;
    files.push_back({at->path(), at->path().lexically_relative(folder).generic_string()});
  }
  if (code) return Error{folder.string(), "", fmt::format("cannot be listed: {}", code.message())};
  if (files.size() == first) return Error{folder.string(), "", "is a folder without meshes (.obj .ply .stl .off) and scenes (.gltf .glb)"};
  std::sort(files.begin() + static_cast<std::ptrdiff_t>(first), files.end(),
            [](const InputFile& a, const InputFile& b) { return a.name < b.name; });
  return Done{};
}

Result<Done> addPath(const fs::path& path, const fs::path& outputFolder, std::vector<InputFile>& files) {
  std::error_code code;
  if (fs::is_directory(path, code)) return addFolder(path, outputFolder, files);
  files.push_back({path, path.lexically_normal().generic_string()});
  return Done{};
}

Result<std::vector<fs::path>> readList(const fs::path& file) {
  const auto bytes = readFile(file, kLargestList);
  if (!bytes) return bytes.error();
  const std::string_view text(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size());
  std::vector<fs::path> paths;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty() && line[0] != '#') paths.emplace_back(line);
    begin = end + 1;
  }
  if (paths.empty()) return Error{file.string(), "", "is a list without files"};
  return paths;
}

/// The folder of an input before names are told apart.
fs::path folderOf(const InputFile& file, bool withExtension) {
  fs::path name = file.name;
  if (name.is_absolute() || name.begin() == name.end() || *name.begin() == "..") name = name.filename();
  return withExtension ? name : name.replace_extension();
}

/// The set that begins at pattern[at] == '[': whether `c` is in it, and where it ends; nothing when it has no end.
bool inSet(std::string_view pattern, std::size_t& at, char c, bool& whole) {
  std::size_t i = at + 1;
  const bool negated = i < pattern.size() && (pattern[i] == '!' || pattern[i] == '^');
  if (negated) ++i;
  bool found = false;
  for (const std::size_t first = i; i < pattern.size() && (pattern[i] != ']' || i == first); ++i) {
    const char low = pattern[i];
    const bool range = i + 2 < pattern.size() && pattern[i + 1] == '-' && pattern[i + 2] != ']';
    const char high = range ? pattern[i + 2] : low;
    found |= low <= c && c <= high;
    if (range) i += 2;
  }
  whole = i < pattern.size();
  if (whole) at = i;
  return found != negated;
}

bool matches(std::string_view pattern, std::string_view name) {
  for (std::size_t p = 0; p < pattern.size(); ++p) {
    if (pattern[p] == '*') {
      const bool deep = p + 1 < pattern.size() && pattern[p + 1] == '*';
      std::string_view rest = pattern.substr(p + (deep ? 2 : 1));
      if (deep && rest.starts_with('/') && matches(rest.substr(1), name)) return true;
      for (std::size_t skipped = 0;; ++skipped) {
        if (matches(rest, name.substr(skipped))) return true;
        if (skipped == name.size() || (!deep && name[skipped] == '/')) return false;
      }
    }
    if (name.empty()) return false;
    const char c = name[0];
    bool whole = false;
    std::size_t end = p;
    if (pattern[p] == '[' && c != '/') {
      const bool found = inSet(pattern, end, c, whole);
      if (whole && !found) return false;
    }
    if (whole) {
      p = end;
    } else if (pattern[p] == '?') {
      if (c == '/') return false;
    } else {
      if (pattern[p] == '\\' && p + 1 < pattern.size()) ++p;
      if (pattern[p] != c) return false;
    }
    name.remove_prefix(1);
  }
  return name.empty();
}

}  // namespace

Result<Inputs> expandInputs(const std::vector<fs::path>& arguments, const fs::path& outputFolder) {
  Inputs inputs;
  for (const fs::path& argument : arguments) {
    const std::string text = argument.string();
    if (!text.starts_with('@')) {
      if (auto added = addPath(argument, outputFolder, inputs.files); !added) return added.error();
      continue;
    }
    inputs.lists.emplace_back(text.substr(1));
    const auto paths = readList(inputs.lists.back());
    if (!paths) return paths.error();
    for (const fs::path& path : paths.value())
      if (auto added = addPath(path, outputFolder, inputs.files); !added) return added.error();
  }
  return inputs;
}

Result<std::vector<fs::path>> foldersOfEach(const std::vector<InputFile>& files) {
  std::map<fs::path, int> uses;
  for (const InputFile& file : files) ++uses[folderOf(file, false)];
  std::vector<fs::path> folders;
  std::map<fs::path, const InputFile*> taken;
  for (const InputFile& file : files) {
    folders.push_back(folderOf(file, uses[folderOf(file, false)] > 1));
    const auto [place, fresh] = taken.emplace(folders.back(), &file);
    if (!fresh)
      return Error{file.path.string(), "", fmt::format("would be baked into the same folder as {}", place->second->path.string())};
  }
  return folders;
}

bool matchesGlob(std::string_view pattern, std::string_view name) {
  if (pattern.find('/') == std::string_view::npos) name = name.substr(name.rfind('/') + 1);
  return matches(pattern, name);
}

}  // namespace overcast
