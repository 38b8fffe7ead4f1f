// The tree keeps its layers (DESIGN 1), and the checker that says so can fail.
#include "tests/layering/layering.h"

#include <ostream>
#include <string>

#include <gtest/gtest.h>

namespace overcast {
namespace {

TEST(Layering, TheTreeKeepsItsLayers) {
  std::size_t filesSeen = 0;
  const auto violations = checkTree(OVERCAST_SOURCE_FOLDER, &filesSeen);
  EXPECT_GT(filesSeen, 20u);
  for (const Violation& violation : violations) ADD_FAILURE() << describe(violation);
}

struct BadSnippet {
  const char* file;
  const char* line;
};

void PrintTo(const BadSnippet& snippet, std::ostream* stream) {
  *stream << snippet.file << ": " << snippet.line;
}

class BadIncludes : public testing::TestWithParam<BadSnippet> {};

TEST_P(BadIncludes, AreNamedWithTheirLine) {
  const std::string text = std::string("// first line\n\n") + GetParam().line + "\nint x;\n";
  const auto violations = checkSource(GetParam().file, text);
  ASSERT_EQ(violations.size(), 1u);
  EXPECT_EQ(violations[0].line, 3);
  EXPECT_EQ(violations[0].file, GetParam().file);
  EXPECT_NE(describe(violations[0]).find("include"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Rooms, BadIncludes,
                         testing::Values(BadSnippet{"formats/scene.cpp", "#include \"bake/volume.h\""},
                                         BadSnippet{"formats/scene.h", "#include \"runtime/scene.h\""},
                                         BadSnippet{"formats/scene.cpp", "#include <runtime/scene.h>"},
                                         BadSnippet{"bake/volume.cpp", "#include \"runtime/scene.h\""},
                                         BadSnippet{"runtime/scene.cpp", "#include \"bake/volume.h\""},
                                         BadSnippet{"runtime/player/main.cpp", "# include \"bake/sign.h\""},
                                         BadSnippet{"runtime/scene.cpp", "  #  include  \"tests/reference/closest.h\""},
                                         BadSnippet{"data/make/main.cpp", "#include \"bake/volume.h\""},
                                         BadSnippet{"bake/volume.cpp", "#include \"../runtime/scene.h\""},
                                         BadSnippet{"tests/reference/sky.cpp", "#include \"runtime/passes/shade/shade.h\""},
                                         BadSnippet{"tests/reference/closest.cpp", "#include \"bake/distance.h\""},
                                         BadSnippet{"tests/reference/closest.cpp", "#include \"formats/files.h\""},
                                         BadSnippet{"runtime/passes/shade/shade.frag.glsl", "#include \"formats/volume.h\""}));

INSTANTIATE_TEST_SUITE_P(Libraries, BadIncludes,
                         testing::Values(BadSnippet{"formats/volume.h", "#include <openvdb/openvdb.h>"},
                                         BadSnippet{"bake/volume.cpp", "#include <openvdb/openvdb.h>"},
                                         BadSnippet{"bake/repair.h", "#include <CGAL/Polygon_mesh_processing/repair.h>"},
                                         BadSnippet{"formats/mesh.cpp", "#include <CGAL/Surface_mesh.h>"},
                                         BadSnippet{"runtime/scene.cpp", "#include <tiny_gltf.h>"},
                                         BadSnippet{"runtime/frame.cpp", "#include <embree3/rtcore.h>"},
                                         BadSnippet{"bake/distance.h", "#include <embree3/rtcore.h>"},
                                         BadSnippet{"formats/mesh.h", "#include <OpenMesh/Core/IO/MeshIO.hh>"},
                                         BadSnippet{"bake/main.cpp", "#include <ImfRgbaFile.h>"},
                                         BadSnippet{"runtime/vulkan/pipeline.h", "#include <glslang/Public/ShaderLang.h>"}));

TEST(Layering, AllowedIncludesPass) {
  EXPECT_TRUE(checkSource("bake/volume.cpp", "#include \"bake/volume.h\"\n#include \"formats/mesh.h\"\n#include <vector>\n").empty());
  EXPECT_TRUE(checkSource("formats/volume.cpp", "#include <openvdb/openvdb.h>\n").empty());
  EXPECT_TRUE(checkSource("tests/runtime/composite_test.cpp", "#include \"bake/volume.h\"\n#include \"runtime/frame.h\"\n").empty());
  EXPECT_TRUE(checkSource("runtime/passes/shade/shade.frag.glsl", "#include \"runtime/passes/shade/shade.h\"\n").empty());
  EXPECT_TRUE(checkSource("tests/bench/x.comp.glsl", "#include \"tests/bench/x.h\"\n").empty());
  EXPECT_FALSE(checkSource("runtime/x.comp.glsl", "#include \"tests/bench/x.h\"\n").empty());
}

TEST(Layering, LongFilesAreNamed) {
  std::string text;
  for (int i = 0; i < 500; ++i) text += "int x;\n";
  EXPECT_TRUE(checkSource("bake/volume.cpp", text).empty());
  const auto violations = checkSource("bake/volume.cpp", text + "int x;\n");
  ASSERT_EQ(violations.size(), 1u);
  EXPECT_EQ(describe(violations[0]), "bake/volume.cpp:0: 501 lines: at most 500 lines");
}

}  // namespace
}  // namespace overcast
