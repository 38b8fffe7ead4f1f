#include "runtime/vulkan/timer.h"

#include <array>

namespace overcast {
namespace {

std::uint32_t query(const PassTimer& timer, std::uint32_t slot, std::uint32_t pass) {
  const auto passes = static_cast<std::uint32_t>(timer.names.size());
  OVERCAST_REQUIRE(slot < timer.slots && pass < passes, "pass {} of {}, slot {} of {}", pass, passes, slot, timer.slots);
  return 2 * (slot * passes + pass);
}

}  // namespace

Result<PassTimer> makePassTimer(const Device& device, std::vector<std::string> names, std::uint32_t slots) {
  PassTimer timer;
  timer.names = std::move(names);
  timer.slots = slots;
  timer.ran.assign(timer.names.size() * slots, false);
  timer.nanosecondsPerTick = static_cast<double>(device.properties.limits.timestampPeriod);
  if (device.timestampBits > 0) timer.tickMask = ~std::uint64_t{0} >> (64 - device.timestampBits);
  VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = static_cast<std::uint32_t>(2 * timer.ran.size());
  const VkResult made = vkCreateQueryPool(device.device, &info, nullptr, &timer.pool);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a query pool");
  return timer;
}

void destroyPassTimer(const Device& device, PassTimer& timer) {
  vkDestroyQueryPool(device.device, timer.pool, nullptr);
  timer = {};
}

void beginTimedFrame(VkCommandBuffer commands, PassTimer& timer, std::uint32_t slot) {
  const auto passes = static_cast<std::uint32_t>(timer.names.size());
  for (std::uint32_t pass = 0; pass < passes; ++pass) timer.ran[slot * passes + pass] = false;
  if (timer.tickMask != 0) vkCmdResetQueryPool(commands, timer.pool, query(timer, slot, 0), 2 * passes);
}

void beginPass(VkCommandBuffer commands, PassTimer& timer, std::uint32_t slot, std::uint32_t pass) {
  if (timer.tickMask != 0) vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, timer.pool, query(timer, slot, pass));
}

void endPass(VkCommandBuffer commands, PassTimer& timer, std::uint32_t slot, std::uint32_t pass) {
  if (timer.tickMask == 0) return;
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, timer.pool, query(timer, slot, pass) + 1);
  timer.ran[slot * timer.names.size() + pass] = true;
}

Result<std::vector<PassTime>> passTimes(const Device& device, const PassTimer& timer, std::uint32_t slot) {
  std::vector<PassTime> times;
  for (std::uint32_t pass = 0; pass < timer.names.size(); ++pass) {
    PassTime time{timer.names[pass], 0.0, !timer.ran[slot * timer.names.size() + pass]};
    if (!time.skipped) {
      std::array<std::uint64_t, 2> ticks{};
      const VkResult read = vkGetQueryPoolResults(device.device, timer.pool, query(timer, slot, pass), 2, sizeof ticks, ticks.data(),
                                                  sizeof ticks[0], VK_QUERY_RESULT_64_BIT);
      if (read != VK_SUCCESS) return vulkanError(read, "cannot read timestamps");
      const std::uint64_t elapsed = (ticks[1] - ticks[0]) & timer.tickMask;
      time.milliseconds = static_cast<double>(elapsed) * timer.nanosecondsPerTick * 1e-6;
    }
    times.push_back(time);
  }
  return times;
}

}  // namespace overcast
