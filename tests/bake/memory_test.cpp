// Memory: the bound that bakes are let in by is one, and the gate keeps to its limit.
#include "bake/memory.h"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/bake/test_meshes.h"
#include "tests/formats/temporary_folder.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

/// Bytes that baking takes at its peak beyond what is there before, in a program of its own.
std::uint64_t measuredPeak(const Mesh& mesh, const BakeSettings& settings) {
  ::malloc_trim(0);
  const std::uint64_t before = residentMemory();
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak starts anew
  MeshBake job;
  EXPECT_TRUE(bakeMesh(job, mesh, settings).ok());
  return peakMemory() - std::min(peakMemory(), before);
}

BakeSettings volumeOf(int resolution) {
  BakeSettings settings;
  settings.volume.resolution = resolution;
  settings.volume.errorSamples = 200;
  return settings;
}

BakeSettings choiceUpTo(int largest, double maxError) {
  BakeSettings settings;
  settings.choice.emplace();
  settings.choice->largest = largest;
  settings.choice->maxError = maxError;
  settings.choice->measure.samples = settings.volume.errorSamples = 200;
  return settings;
}

TEST(BakeMemory, IsAnUpperBoundAndNoWildOne) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer's own memory counts too";
#endif
  const Mesh ball = test::sphereMesh(glm::dvec3(0.0), 1.0, 150, 150), small = test::sphereMesh(glm::dvec3(0.0), 1.0, 8, 8);
  const Mesh soup = reference::triangleSoup(1, 3'000, 1.0);
  struct Case {
    const char* name;
    const Mesh& mesh;
    BakeSettings settings;
    double slack;  ///< the bound is not above so many times what was measured
  };
  for (const Case& c : std::initializer_list<Case>{{"many triangles", ball, volumeOf(16), 4.0},
                                                   {"loose triangles", soup, volumeOf(8), 12.0},
                                                   {"a large volume", small, volumeOf(160), 5.0},
                                                   {"large candidates", small, choiceUpTo(64, 1e-9), 12.0}}) {
    const std::uint64_t bound = bakeMemory(c.mesh, c.settings), peak = measuredPeak(c.mesh, c.settings);
    EXPECT_GE(bound, peak) << c.name;
    EXPECT_LE(static_cast<double>(bound), c.slack * static_cast<double>(peak)) << c.name << ": measured " << peak;
  }
}

TEST(FileMemory, IsAboveWhatTheFileTurnsOutToNeed) {
  const test::TemporaryFolder folder;
  const Mesh ball = test::sphereMesh(glm::dvec3(0.0), 1.0, 60, 60);
  ASSERT_TRUE(writeOff(folder.path / "ball.off", ball).ok());
  const FileMemory file = fileMemory(folder.path / "ball.off", volumeOf(32));
  EXPECT_GE(file.read, meshMemory(ball));
  EXPECT_GE(file.bake, bakeMemory(ball, volumeOf(32)));
  EXPECT_EQ(fileMemory(folder.path / "missing.off", volumeOf(32)).read, 0u);
}

TEST(MemoryGate, KeepsToItsLimitAndLetsOneIn) {
  MemoryGate gate(100);
  std::atomic<int> held{0}, alone{0};
  std::atomic<bool> exceeded{false};
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 200; ++i) {
        const int bytes = (i * 7 + t * 31) % 130;
        MemoryGate::Share share(gate, static_cast<std::uint64_t>(bytes));
        const int now = held += bytes;
        if (bytes > 100 && now == bytes) ++alone;
        if (now > std::max(100, bytes)) exceeded = true;
        std::this_thread::yield();
        held -= bytes / 2;
        share.shrink(static_cast<std::uint64_t>(bytes - bytes / 2));
        held -= bytes - bytes / 2;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_FALSE(exceeded);
  EXPECT_GT(alone, 0) << "jobs above the limit ran by themselves";
}

TEST(MemoryGate, WhatIsSettledStaysHeldButKeepsNobodyOut) {
  MemoryGate gate(100);
  MemoryGate::Share read(gate, 90);
  read.settle(80);
  MemoryGate::Share first(gate, 50);  // over the limit, and the only one at work
  std::atomic<bool> entered{false};
  std::thread waiting([&] {
    const MemoryGate::Share second(gate, 10);
    entered = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  EXPECT_FALSE(entered);
  first.shrink(10);
  waiting.join();
  EXPECT_TRUE(entered);
}

}  // namespace
}  // namespace overcast
