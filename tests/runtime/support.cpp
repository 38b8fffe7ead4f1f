#include "tests/runtime/support.h"

#include <glob.h>
#include <unistd.h>

#include <cstdlib>

namespace overcast::test {
namespace {

namespace fs = std::filesystem;

/// Holds the folder of everything this test program writes and points the environment at it before main.
struct Surroundings {
  fs::path folder;

  Surroundings() {
    std::string pattern = (fs::temp_directory_path() / "overcast-test-XXXXXX").string();
    if (mkdtemp(pattern.data())) folder = pattern;
    setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1);
    setenv("XDG_RUNTIME_DIR", folder.c_str(), 0);
    if (!std::getenv("OVERCAST_TEST_ANY_DEVICE")) chooseLavapipe();
  }
  ~Surroundings() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  Surroundings(const Surroundings&) = delete;
  Surroundings& operator=(const Surroundings&) = delete;

  static void chooseLavapipe() {
    glob_t found{};
    if (glob("/usr/share/vulkan/icd.d/lvp_icd*.json", 0, nullptr, &found) == 0) setenv("VK_DRIVER_FILES", found.gl_pathv[0], 1);
    globfree(&found);
  }
};

const Surroundings kSurroundings;

}  // namespace

fs::path temporaryFolder() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  fs::path folder = kSurroundings.folder / (std::string(info->test_suite_name()) + "." + info->name());
  fs::create_directories(folder);
  return folder;
}

void DeviceTest::SetUp() {
  DeviceSettings settings;
  settings.validation = true;
  Result<Device> opened = openDevice(settings);
  ASSERT_TRUE(opened.ok()) << message(opened.error());
  device = std::move(opened).value();
}

void DeviceTest::TearDown() {
  closeDevice(device);
  if (!device.validation) return;
  for (const std::string& text : device.validation->texts) ADD_FAILURE() << text;
  EXPECT_EQ(validationMessages(device), 0u);
}

}  // namespace overcast::test
