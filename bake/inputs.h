// Inputs: what the arguments of a bake name (files, folders, lists of files), and where each of them goes when each is baked on its own.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/result.h"

namespace overcast {

/// One mesh or scene file.
struct InputFile {
  std::filesystem::path path;  ///< as it is opened and named in messages
  std::string name;            ///< with forward slashes: the path below the folder that was named; else the path as given, normalised
};

/// What was named, and which files decided that.
struct Inputs {
  std::vector<InputFile> files;
  std::vector<std::filesystem::path> lists;  ///< list files that were read
};

/// Files stay as they are, in the order given. A folder stands for every mesh and scene in it and below, sorted by name; symbolic links to
/// folders are not followed, and `outputFolder` is left out. "@list.txt" stands for the files and folders of that text file, one a line,
/// relative to the current folder; blank lines and lines that begin with # do not count. A file named twice counts twice. An Error when a
/// folder cannot be listed or holds nothing, or a list cannot be read or is empty. Whether files exist is not looked at.
Result<Inputs> expandInputs(const std::vector<std::filesystem::path>& arguments, const std::filesystem::path& outputFolder);

/// For each input its folder below the output folder when each is baked on its own: its name without extension, with the extension where
/// two would be the same; only the file name where the name is absolute or begins with "..". An Error when two inputs still share one.
Result<std::vector<std::filesystem::path>> foldersOfEach(const std::vector<InputFile>& files);

/// Whether a name matches a pattern: * stands for anything but a slash, ** also for slashes, ? for one character but a slash, [a-z] and
/// [!a-z] for one of a set, \ takes the special meaning from the next character. A pattern without a slash is matched with the last part
/// of the name alone. "**/" also stands for nothing.
bool matchesGlob(std::string_view pattern, std::string_view name);

}  // namespace overcast
