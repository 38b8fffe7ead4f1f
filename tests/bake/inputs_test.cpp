// Inputs: patterns, folders, lists, and where each input goes.
#include "bake/inputs.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Globs, MatchAsDocumented) {
  struct Case {
    const char* pattern;
    const char* name;
    bool matches;
  };
  for (const Case& c : std::initializer_list<Case>{
           {"*.off", "a.off", true},
           {"*.off", "props/chairs/a.off", true},
           {"*.off", "a.offx", false},
           {"a.off", "props/a.off", true},
           {"props/*.off", "props/a.off", true},
           {"props/*.off", "props/chairs/a.off", false},
           {"props/**", "props/chairs/a.off", true},
           {"props/**/a.off", "props/a.off", true},
           {"props/**/a.off", "props/x/y/a.off", true},
           {"props/**/a.off", "propsx/a.off", false},
           {"**/a.off", "a.off", true},
           {"**/a.off", "ba.off", false},
           {"*/a.off", "a.off", false},
           {"?.off", "a.off", true},
           {"x/?", "x/", false},
           {"x?y", "x/y", false},
           {"[a-c]*.off", "b1.off", true},
           {"[a-c]*.off", "d1.off", false},
           {"[!a-c]*.off", "d1.off", true},
           {"[]]x", "]x", true},
           {"[a-]x", "-x", true},
           {"[x", "[x", true},
           {"x/[/]y", "x//y", false},
           {"\\*.off", "*.off", true},
           {"\\*.off", "a.off", false},
           {"*", "", true},
           {"", "", true},
           {"*a*b*c", "xxaxxbxxc", true},
           {"*a*b*c", "xxaxxbxx", false},
           {"größe*", "größe.off", true},
       })
    EXPECT_EQ(matchesGlob(c.pattern, c.name), c.matches) << c.pattern << " on " << c.name;
}

class InputFiles : public testing::Test {
 protected:
  void touch(const std::string& name, const std::string& text = "") {
    fs::create_directories((folder.path / name).parent_path());
    std::ofstream(folder.path / name) << text;
  }
  std::vector<std::string> namesOf(const std::vector<fs::path>& arguments, const fs::path& output = {}) {
    const auto inputs = expandInputs(arguments, output);
    EXPECT_TRUE(inputs.ok()) << message(inputs.error());
    std::vector<std::string> names;
    if (inputs)
      for (const InputFile& file : inputs.value().files) names.push_back(file.name);
    return names;
  }

  fs::path listAt(const char* name) const { return fmt::format("@{}", (folder.path / name).string()); }

  test::TemporaryFolder folder;
};

TEST_F(InputFiles, FoldersStandForWhatIsInThem) {
  for (const char* name : {"lib/b.off", "lib/a.OBJ", "lib/sub/c.gltf", "lib/sub/c.bin", "lib/notes.txt", "lib/out/scene.gltf"}) touch(name);
  fs::create_directory_symlink(folder.path / "lib", folder.path / "lib/loop");
  fs::create_symlink("nowhere", folder.path / "lib/broken.off");
  EXPECT_THAT(namesOf({folder.path / "lib"}, folder.path / "lib/out"), ElementsAre("a.OBJ", "b.off", "sub/c.gltf"));
  EXPECT_THAT(namesOf({folder.path / "lib/"}, folder.path / "lib/../lib/out"), ElementsAre("a.OBJ", "b.off", "sub/c.gltf"));
  EXPECT_THAT(namesOf({"x/./y.off", folder.path / "lib/sub", "-"}), ElementsAre("x/y.off", "c.gltf", "-"));
  fs::create_directory(folder.path / "empty");
  const auto empty = expandInputs({folder.path / "empty"}, {});
  ASSERT_FALSE(empty.ok());
  EXPECT_THAT(message(empty.error()), HasSubstr("empty: is a folder without meshes"));
}

TEST_F(InputFiles, ListsNameOneFileALine) {
  touch("lib/b.off");
  touch("list.txt", fmt::format("# a comment\n\na b.off\r\n{}\nlast.obj", (folder.path / "lib").string()));
  const auto inputs = expandInputs({"first.off", listAt("list.txt")}, {});
  ASSERT_TRUE(inputs.ok());
  std::vector<std::string> paths;
  for (const InputFile& file : inputs.value().files) paths.push_back(file.path.string());
  EXPECT_THAT(paths, ElementsAre("first.off", "a b.off", (folder.path / "lib/b.off").string(), "last.obj"));
  EXPECT_THAT(inputs.value().lists, ElementsAre(folder.path / "list.txt"));
  touch("none.txt", "\n# nothing\n");
  EXPECT_FALSE(expandInputs({listAt("none.txt")}, {}).ok());
  EXPECT_FALSE(expandInputs({listAt("missing.txt")}, {}).ok());
}

TEST(FoldersOfEach, KeepInputsApart) {
  const auto folders = foldersOfEach({{"lib/a.off", "a.off"},
                                      {"lib/a.obj", "a.obj"},
                                      {"lib/sub/a.off", "sub/a.off"},
                                      {"/x/b.off", "/x/b.off"},
                                      {"../c.d.off", "../c.d.off"},
                                      {"plain", "plain"}});
  ASSERT_TRUE(folders.ok());
  EXPECT_THAT(folders.value(), ElementsAre("a.off", "a.obj", "sub/a", "b", "c.d", "plain"));
  const auto clash = foldersOfEach({{"/x/b.off", "/x/b.off"}, {"../b.off", "../b.off"}});
  ASSERT_FALSE(clash.ok());
  EXPECT_THAT(message(clash.error()), HasSubstr("same folder as /x/b.off"));
}

}  // namespace
}  // namespace overcast
