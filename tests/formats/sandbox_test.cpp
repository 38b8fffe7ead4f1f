#include "formats/sandbox.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using Bytes = std::vector<std::byte>;
using Clock = std::chrono::steady_clock;

constexpr const char* kFile = "some/mesh.ply";

Result<Bytes> run(const std::function<Result<Bytes>()>& parse, const SandboxLimits& limits = {}) {
  return runSandboxed(kFile, limits, parse);
}

std::string reasonOf(const Result<Bytes>& result) {
  return result.ok() ? "(no error)" : result.error().reason;
}

SandboxLimits within(int milliseconds) {
  SandboxLimits limits;
  limits.wallTime = std::chrono::milliseconds(milliseconds);
  return limits;
}

/// So that the compiler cannot see that the pointer is null.
volatile std::uintptr_t nullAddress = 0;

TEST(Sandbox, HandsBackTheBytes) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{65'537}, std::size_t{20} << 20}) {
    const auto result = run([&]() -> Result<Bytes> {
      Bytes bytes(size);
      for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 7 % 251);
      return bytes;
    });
    ASSERT_TRUE(result.ok()) << message(result.error());
    ASSERT_EQ(result.value().size(), size);
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(result.value()[i], static_cast<std::byte>(i * 7 % 251));
  }
}

TEST(Sandbox, HandsBackTheError) {
  const auto result = run([]() -> Result<Bytes> { return Error{"", "line 3", "odd"}; });
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(message(result.error()), "some/mesh.ply: line 3: odd");
}

TEST(Sandbox, ACrashIsAnError) {
  EXPECT_EQ(reasonOf(run([]() -> Result<Bytes> { std::abort(); })), "reader crashed (signal 6)");
  EXPECT_EQ(reasonOf(run([]() -> Result<Bytes> {
              ::raise(SIGSEGV);
              return Bytes{};
            })),
            "reader crashed (signal 11)");
  EXPECT_FALSE(run([]() -> Result<Bytes> { return Bytes(static_cast<std::size_t>(*reinterpret_cast<int*>(nullAddress))); }).ok());
  EXPECT_EQ(reasonOf(run([]() -> Result<Bytes> { ::_exit(3); })), "reader ended without an answer (exit code 3)");
}

TEST(Sandbox, AHangIsKilled) {
  const auto begin = Clock::now();
  const auto asleep = run(
      []() -> Result<Bytes> {
        for (;;) ::pause();
      },
      within(200));
  EXPECT_EQ(reasonOf(asleep), "reader took longer than 0.2 s");
  volatile bool forever = true;
  const auto busy = run(
      [&]() -> Result<Bytes> {
        while (forever) {
        }
        return Bytes{};
      },
      within(200));
  EXPECT_EQ(reasonOf(busy), "reader took longer than 0.2 s");
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(5));
}

TEST(Sandbox, MemoryIsLimited) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "AddressSanitizer maps more address space than any limit";
#endif
  SandboxLimits limits;
  limits.memoryBytes = std::uint64_t{64} << 20;
  const auto allocate = [&](std::size_t megabytes) {
    return run([=]() -> Result<Bytes> { return Bytes(1, Bytes(megabytes << 20, std::byte{1})[megabytes]); }, limits);
  };
  EXPECT_TRUE(allocate(16).ok());
  EXPECT_EQ(reasonOf(allocate(128)), "reading it needs more than 64 MB of memory");
  const auto absurd = run([]() -> Result<Bytes> { return Bytes(std::size_t{1} << 62); }, limits);
  EXPECT_EQ(reasonOf(absurd), "reading it needs more than 64 MB of memory");
  // What the parent has mapped does not count.
  const Bytes mine(std::size_t{256} << 20);
  EXPECT_TRUE(allocate(16).ok()) << mine.size();
}

TEST(Sandbox, ALargeResultIsRefused) {
  SandboxLimits limits;
  limits.resultBytes = std::uint64_t{1} << 20;
  EXPECT_TRUE(run([]() -> Result<Bytes> { return Bytes(std::size_t{1} << 20); }, limits).ok());
  EXPECT_EQ(reasonOf(run([]() -> Result<Bytes> { return Bytes((std::size_t{1} << 20) + 1); }, limits)),
            "holds more than the 1 MB accepted");
}

TEST(Sandbox, AnExceptionIsAnErrorOfOneLine) {
  EXPECT_EQ(reasonOf(run([]() -> Result<Bytes> { throw std::runtime_error("two\nlines"); })), "reader gave up: two lines");
  EXPECT_FALSE(run([]() -> Result<Bytes> { throw 5; }).ok());
}

TEST(Sandbox, TheChildIsSilent) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const auto result = run([]() -> Result<Bytes> {
    std::cout << "noise" << std::endl;
    std::cerr << "noise" << std::endl;
    return Bytes(static_cast<std::size_t>(::write(1, "noise", 5)));
  });
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result.value().size(), 5u);
}

TEST(Sandbox, HandlersOfTheParentDoNotRunInTheChild) {
  const auto before = ::signal(SIGTERM, [](int) { ::_exit(0); });
  EXPECT_EQ(reasonOf(run([]() -> Result<Bytes> {
              ::raise(SIGTERM);
              return Bytes{};
            })),
            "reader crashed (signal 15)");
  ::signal(SIGTERM, before);
}

TEST(Sandbox, ManyAtOnceLeaveNoZombiesAndNoOpenFiles) {
  const std::size_t openBefore = test::entries("/proc/self/fd");
  std::atomic<int> wrong{0};
  // Threads of TBB are alive while their siblings fork.
  tbb::parallel_for(0, 200, [&](int i) {
    const auto result = run([&]() -> Result<Bytes> {
      if (i % 5 == 4) std::abort();
      return Bytes(static_cast<std::size_t>(i) * 1000, static_cast<std::byte>(i));
    });
    const Bytes expected(static_cast<std::size_t>(i) * 1000, static_cast<std::byte>(i));
    if (i % 5 == 4 ? reasonOf(result) != "reader crashed (signal 6)" : !result.ok() || result.value() != expected) ++wrong;
  });
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
  EXPECT_EQ(test::entries("/proc/self/fd"), openBefore);
}

// The threads that TBB has in the parent do not exist in the child: work offered to them would never come back.
TEST(Sandbox, ReadersMayUseTbb) {
  for (int round = 0; round < 100; ++round) {
    std::atomic<int> warm{0};
    tbb::parallel_for(0, 1000, [&](int) { ++warm; });
    const auto result = run([]() -> Result<Bytes> {
      std::atomic<int> sum{0};
      tbb::parallel_for(0, 1000, [&](int i) { sum += i; });
      return sum == 499500 ? Result<Bytes>(Bytes(1)) : Result<Bytes>(Error{"", "", "wrong sum"});
    });
    ASSERT_TRUE(result.ok()) << round << ": " << message(result.error());
  }
}

TEST(Sandbox, AHungNeighbourDoesNotHoldUpTheOthers) {
  std::atomic<bool> hung{true};
  std::thread slow([&] {
    const auto result = run(
        []() -> Result<Bytes> {
          for (;;) ::pause();
        },
        within(4000));
    EXPECT_FALSE(result.ok());
    hung = false;
  });
  for (int i = 0; i < 20; ++i) EXPECT_EQ(reasonOf(run([]() -> Result<Bytes> { std::abort(); })), "reader crashed (signal 6)");
  EXPECT_TRUE(hung) << "the others waited for the neighbour";
  slow.join();
}

}  // namespace
}  // namespace overcast
