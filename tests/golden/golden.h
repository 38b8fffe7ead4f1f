// Golden: the list of golden pictures (data/golden/goldens.json) and how each is rendered, as a user would: bake, then play.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/golden/compare.h"

namespace overcast {

struct Golden {
  std::string name;               ///< of the picture: data/golden/NAME.png
  std::string scene;              ///< data/scenes/SCENE.gltf, or data/scenes/SCENE where it has an extension
  int frame = 0;                  ///< at 30 per second
  std::vector<std::string> bake;  ///< flags of overcast-bake
  std::vector<std::string> play;  ///< flags of overcast-player: size, camera
  Tolerance tolerance;
  std::string reason;  ///< what the picture watches over
};

/// Where things are: the tree, the programs, and a folder for what is rendered and compared.
struct GoldenFolders {
  std::filesystem::path source;
  std::filesystem::path programs;
  std::filesystem::path output;
};

/// Reads the list; an Error that names the entry when a field is missing or of the wrong type.
Result<std::vector<Golden>> readGoldens(const std::filesystem::path& file);

/// Bakes and plays the scene; returns the picture's file. On an Error the reason names the log of the command that failed.
Result<std::filesystem::path> renderGolden(const Golden& golden, const GoldenFolders& folders);

/// Compares a rendered picture with its golden. When it differs by more than the tolerance, an Error that says by how much and where the
/// picture, the golden and the difference image are.
Result<Difference> checkGolden(const Golden& golden, const std::filesystem::path& picture, const GoldenFolders& folders);

/// Makes the picture the new golden.
Result<Done> renewGolden(const Golden& golden, const std::filesystem::path& picture, const GoldenFolders& folders);

}  // namespace overcast
