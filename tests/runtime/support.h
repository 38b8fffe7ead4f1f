// Support: what tests on a Vulkan device share. All of them run on Mesa's lavapipe, so that results do not depend on the machine's GPU;
// set OVERCAST_TEST_ANY_DEVICE=1 to use what the loader offers instead.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "runtime/vulkan/device.h"

namespace overcast::test {

/// A fresh folder of this test, gone at the end of the program.
std::filesystem::path temporaryFolder();

/// Opens a validated device; afterwards asserts that validation and synchronization validation had nothing to say.
class DeviceTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;
  Device device;
};

}  // namespace overcast::test
