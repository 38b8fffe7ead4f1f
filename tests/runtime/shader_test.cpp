#include "runtime/vulkan/shader.h"

#include <cstdlib>
#include <cstring>
#include <fstream>

#include "formats/files.h"
#include "runtime/shared_types.h"
#include "runtime/vulkan/pipeline.h"
#include "tests/runtime/support.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;

/// A shader root and a cache of this test's own.
class Shaders : public DeviceTest {
 protected:
  void SetUp() override {
    DeviceTest::SetUp();
    folder = temporaryFolder();
    cacheBefore = std::getenv("XDG_CACHE_HOME");
    setenv("OVERCAST_SHADERS", folder.c_str(), 1);
    setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1);
    put("runtime/shared_types.h", "");
    put("runtime/shared.h", "#ifndef H\n#define H\nint plus(int x) { return x + ADDED; }\n#endif\n");
    put("runtime/near/beside.h", "int beside(int x) { return 2 * x; }\n");
    put("runtime/near/good.comp.glsl", R"(#version 460
#include "runtime/shared.h"
#include "beside.h"
layout(local_size_x = 8) in;
layout(push_constant) uniform Push { int offset; };
layout(binding = 0) writeonly buffer Values { int values[]; };
void main() { values[gl_GlobalInvocationID.x] = beside(plus(int(gl_GlobalInvocationID.x))) + offset; }
)");
  }
  void TearDown() override {
    unsetenv("OVERCAST_SHADERS");
    setenv("XDG_CACHE_HOME", cacheBefore.c_str(), 1);
    DeviceTest::TearDown();
  }
  void put(const std::string& path, const std::string& text) {
    fs::create_directories((folder / path).parent_path());
    std::ofstream(folder / path, std::ios::trunc) << text;
  }
  std::vector<fs::path> cached() const {
    std::vector<fs::path> entries;
    if (fs::exists(shaderCacheFolder()))
      for (const auto& entry : fs::directory_iterator(shaderCacheFolder())) entries.push_back(entry.path());
    return entries;
  }
  Shader good{"runtime/near/good.comp.glsl", {{"ADDED", "5"}}};
  fs::path folder;
  std::string cacheBefore;
};

TEST_F(Shaders, RunWithIncludesDefinesBindingsAndPushConstants) {
  ComputeSettings settings;
  settings.shader = good;
  settings.bindings = {{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
  settings.pushBytes = 4;
  Result<Pipeline> pipeline = makeComputePipeline(device, settings);
  ASSERT_TRUE(pipeline.ok()) << message(pipeline.error());
  Result<DescriptorSet> set = makeDescriptorSet(device, pipeline.value());
  Result<GpuBuffer> buffer = makeBuffer(device, 32 * 4, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::device);
  ASSERT_TRUE(set.ok() && buffer.ok());
  writeBuffer(device, set.value(), 0, buffer.value());
  ASSERT_TRUE(runCommands(device, [&](VkCommandBuffer commands) {
                bind(commands, pipeline.value(), set.value());
                push(commands, pipeline.value(), 100);
                vkCmdDispatch(commands, groups(32, 8), 1, 1);
                barrier(commands, kComputeWrite, kTransferRead);
              }).ok());
  const Result<std::vector<std::byte>> bytes = readBuffer(device, buffer.value(), 0, 32 * 4);
  ASSERT_TRUE(bytes.ok());
  for (int i = 0; i < 32; ++i) {
    int value = 0;
    std::memcpy(&value, bytes.value().data() + 4 * i, 4);
    EXPECT_EQ(value, 2 * (i + 5) + 100);
  }
  destroyBuffer(device, buffer.value());
  destroyDescriptorSet(device, set.value());
  destroyPipeline(device, pipeline.value());
}

TEST_F(Shaders, ErrorsNameFileAndLine) {
  put("runtime/bad.comp.glsl", "#version 460\nvoid main() {\n  undeclared = 1;\n}\n");
  const Result<Spirv> bad = compileShader({"runtime/bad.comp.glsl", {}});
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().file, "runtime/bad.comp.glsl");
  EXPECT_EQ(bad.error().place, "line 3");
  EXPECT_NE(bad.error().reason.find("undeclared"), std::string::npos);

  put("runtime/near/beside.h", "\n\nint beside(int x) { return x + }\n");
  const Result<Spirv> inHeader = compileShader(good);
  ASSERT_FALSE(inHeader.ok());
  EXPECT_EQ(inHeader.error().file, "runtime/near/beside.h");
  EXPECT_EQ(inHeader.error().place, "line 3");

  put("runtime/lost.comp.glsl", "#version 460\n#include \"nowhere.h\"\nvoid main() {}\n");
  const Result<Spirv> lost = compileShader({"runtime/lost.comp.glsl", {}});
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.error().place, "line 2");
  EXPECT_NE(lost.error().reason.find("nowhere.h"), std::string::npos);

  const Result<Spirv> absent = compileShader({"runtime/absent.comp.glsl", {}});
  ASSERT_FALSE(absent.ok());
  EXPECT_NE(absent.error().file.find("absent.comp.glsl"), std::string::npos);
}

TEST_F(Shaders, CacheHoldsUntilSomethingIncludedOrDefinedChanges) {
  const Result<Spirv> first = compileShader(good);
  ASSERT_TRUE(first.ok()) << message(first.error());
  EXPECT_FALSE(first.value().fromCache);
  const Result<Spirv> second = compileShader(good);
  ASSERT_TRUE(second.ok());
  EXPECT_TRUE(second.value().fromCache);
  EXPECT_EQ(second.value().words, first.value().words);

  Shader other = good;
  other.defines[0].value = "6";
  EXPECT_FALSE(compileShader(other).value().fromCache);
  put("runtime/near/beside.h", "int beside(int x) { return 3 * x; }\n");
  const Result<Spirv> changed = compileShader(good);
  ASSERT_TRUE(changed.ok());
  EXPECT_FALSE(changed.value().fromCache);
  EXPECT_NE(changed.value().words, first.value().words);
}

TEST_F(Shaders, DamagedCacheEntriesAreCompiledAgain) {
  const std::vector<std::uint32_t> words = compileShader(good).value().words;
  ASSERT_EQ(cached().size(), 1u);
  const fs::path entry = cached().front();
  const auto size = fs::file_size(entry);
  const auto damage = [&](int kind) {
    if (kind == 0) fs::resize_file(entry, size - 4);
    if (kind == 1) fs::resize_file(entry, 0);
    if (kind == 2) {
      std::fstream file(entry, std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(static_cast<std::streamoff>(size / 2));
      file.put('\x5a').put('\x5a');
    }
  };
  for (int kind = 0; kind < 3; ++kind) {
    damage(kind);
    const Result<Spirv> again = compileShader(good);
    ASSERT_TRUE(again.ok());
    EXPECT_FALSE(again.value().fromCache) << "damage " << kind;
    EXPECT_EQ(again.value().words, words);
    EXPECT_TRUE(compileShader(good).value().fromCache) << "the entry was mended after damage " << kind;
  }
}

TEST_F(Shaders, CacheThatCannotBeWrittenCostsOnlyTime) {
  put("file", "a file where the cache folder should be");
  setenv("XDG_CACHE_HOME", (folder / "file").c_str(), 1);
  for (int i = 0; i < 2; ++i) {
    const Result<Spirv> spirv = compileShader(good);
    ASSERT_TRUE(spirv.ok()) << message(spirv.error());
    EXPECT_FALSE(spirv.value().fromCache);
  }
}

TEST_F(Shaders, RootWithoutShadersIsAnErrorThatNamesTheVariable) {
  setenv("OVERCAST_SHADERS", (folder / "nowhere").c_str(), 1);
  const Result<Spirv> spirv = compileShader(good);
  ASSERT_FALSE(spirv.ok());
  EXPECT_NE(message(spirv.error()).find("OVERCAST_SHADERS"), std::string::npos);
}

}  // namespace
}  // namespace overcast::test
