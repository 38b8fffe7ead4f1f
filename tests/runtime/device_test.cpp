#include "runtime/vulkan/device.h"

#include <cstdlib>
#include <cstring>
#include <numeric>

#include "runtime/vulkan/resources.h"
#include "runtime/vulkan/timer.h"
#include "tests/runtime/support.h"

namespace overcast::test {
namespace {

TEST(DeviceList, SaysWhatEachDeviceIs) {
  const std::vector<DeviceInfo> devices = listDevices();
  ASSERT_FALSE(devices.empty());
  for (std::size_t i = 0; i < devices.size(); ++i) {
    EXPECT_EQ(devices[i].index, static_cast<int>(i));
    EXPECT_FALSE(devices[i].name.empty());
    EXPECT_EQ(devices[i].usable, devices[i].reason.empty());
  }
}

TEST(DeviceChoice, TakesIndexAndPartOfNameInAnyCase) {
  const std::vector<DeviceInfo> devices = listDevices();
  ASSERT_FALSE(devices.empty());
  std::string part = devices[0].name.substr(0, 6);
  for (char& c : part) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const std::string& wanted : {std::string("0"), part, std::string()}) {
    DeviceSettings settings;
    settings.device = wanted;
    Result<Device> device = openDevice(settings);
    ASSERT_TRUE(device.ok()) << message(device.error());
    EXPECT_EQ(device.value().info.name, devices[0].name);
    EXPECT_EQ(device.value().validation, nullptr);
    closeDevice(device.value());
  }
}

TEST(DeviceChoice, SaysWhichDevicesThereAreWhenNoneMatches) {
  for (const char* wanted : {"99", "abacus"}) {
    DeviceSettings settings;
    settings.device = wanted;
    const Result<Device> device = openDevice(settings);
    ASSERT_FALSE(device.ok());
    EXPECT_NE(message(device.error()).find(wanted), std::string::npos);
    EXPECT_NE(message(device.error()).find(listDevices().front().name), std::string::npos);
  }
}

TEST(DeviceChoice, SaysWhenThereIsNoDriver) {
  const char* drivers = std::getenv("VK_DRIVER_FILES");
  const std::string before = drivers ? drivers : "";
  setenv("VK_DRIVER_FILES", "/nonexistent.json", 1);
  const Result<Device> device = openDevice({});
  const std::vector<DeviceInfo> devices = listDevices();
  drivers ? setenv("VK_DRIVER_FILES", before.c_str(), 1) : unsetenv("VK_DRIVER_FILES");
  ASSERT_FALSE(device.ok());
  EXPECT_NE(message(device.error()).find("Vulkan"), std::string::npos);
  EXPECT_TRUE(devices.empty());
}

TEST(Validation, HearsMisuse) {
  DeviceSettings settings;
  settings.validation = true;
  Result<Device> opened = openDevice(settings);
  ASSERT_TRUE(opened.ok()) << message(opened.error());
  Device& device = opened.value();
  Result<GpuBuffer> from = makeBuffer(device, 64, 0, MemoryUse::device);
  Result<GpuBuffer> to = makeBuffer(device, 64, 0, MemoryUse::device);
  ASSERT_TRUE(from.ok() && to.ok());
  const Result<Done> ran = runCommands(device, [&](VkCommandBuffer commands) {
    const VkBufferCopy region{0, 0, 64};
    vkCmdCopyBuffer(commands, from.value().buffer, to.value().buffer, 1, &region);
    vkCmdCopyBuffer(commands, from.value().buffer, to.value().buffer, 1, &region);  // write after write without a barrier
  });
  ASSERT_TRUE(ran.ok());
  EXPECT_GE(validationMessages(device), 1u);
  ASSERT_FALSE(device.validation->texts.empty());
  EXPECT_NE(device.validation->texts[0].find("SYNC-HAZARD-WRITE"), std::string::npos) << device.validation->texts[0];
  destroyBuffer(device, from.value());
  destroyBuffer(device, to.value());
  closeDevice(device);
}

class Resources : public DeviceTest {};

TEST_F(Resources, BuffersComeBackAsTheyWent) {
  std::vector<std::uint32_t> sent(1000);
  std::iota(sent.begin(), sent.end(), 7u);
  Result<GpuBuffer> buffer = makeBufferWith(device, std::as_bytes(std::span(sent)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  ASSERT_TRUE(buffer.ok()) << message(buffer.error());
  const Result<std::vector<std::byte>> back = readBuffer(device, buffer.value(), 40, 400);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(std::memcmp(back.value().data(), sent.data() + 10, 400), 0);
  destroyBuffer(device, buffer.value());
}

TEST_F(Resources, ImagesComeBackAsTheyWentInTwoAndThreeDimensions) {
  for (const VkExtent3D extent : {VkExtent3D{17, 9, 1}, VkExtent3D{8, 5, 6}}) {
    ImageSettings settings;
    settings.extent = extent;
    settings.format = VK_FORMAT_R32_SFLOAT;
    settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
    Result<GpuImage> image = makeImage(device, settings);
    ASSERT_TRUE(image.ok()) << message(image.error());
    std::vector<float> sent(extent.width * extent.height * extent.depth);
    std::iota(sent.begin(), sent.end(), 0.5f);
    ASSERT_TRUE(uploadImage(device, image.value(), std::as_bytes(std::span(sent)), kComputeSample).ok());
    const Result<std::vector<std::byte>> back = readImage(device, image.value(), kComputeSample);
    ASSERT_TRUE(back.ok());
    ASSERT_EQ(back.value().size(), sent.size() * sizeof(float));
    EXPECT_EQ(std::memcmp(back.value().data(), sent.data(), back.value().size()), 0);
    destroyImage(device, image.value());
  }
}

TEST_F(Resources, TooLargeImagesAreErrors) {
  ImageSettings settings;
  settings.extent = {1u << 20, 4, 1};
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  const Result<GpuImage> image = makeImage(device, settings);
  ASSERT_FALSE(image.ok());
  EXPECT_NE(message(image.error()).find("1048576x4x1"), std::string::npos);
}

class Timer : public DeviceTest {};

TEST_F(Timer, ReportsPassesThatRanAndThoseThatDidNot) {
  Result<PassTimer> timer = makePassTimer(device, {"first", "second"}, 2);
  ASSERT_TRUE(timer.ok());
  for (std::uint32_t slot = 0; slot < 2; ++slot) {
    const Result<Done> ran = runCommands(device, [&](VkCommandBuffer commands) {
      beginTimedFrame(commands, timer.value(), slot);
      beginPass(commands, timer.value(), slot, slot);
      endPass(commands, timer.value(), slot, slot);
    });
    ASSERT_TRUE(ran.ok());
    const Result<std::vector<PassTime>> times = passTimes(device, timer.value(), slot);
    ASSERT_TRUE(times.ok());
    ASSERT_EQ(times.value().size(), 2u);
    EXPECT_EQ(times.value()[0].name, "first");
    EXPECT_EQ(times.value()[0].skipped, slot != 0);
    EXPECT_EQ(times.value()[1].skipped, slot != 1);
    EXPECT_GE(times.value()[slot].milliseconds, 0.0);
    EXPECT_LT(times.value()[slot].milliseconds, 10000.0);
  }
  destroyPassTimer(device, timer.value());
}

}  // namespace
}  // namespace overcast::test
