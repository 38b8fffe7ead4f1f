// The cache: what goes in comes out, whatever happens to its files, and several processes may use it at once.
#include "bake/cache.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/files.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;
using Bytes = Cache::Bytes;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Bytes bytesOf(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::string keyOf(std::string_view text) {
  return contentHash(std::as_bytes(std::span(text)));
}

std::vector<fs::path> filesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void overwrite(const fs::path& file, const Bytes& bytes) {
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

class Caches : public testing::Test {
 protected:
  std::unique_ptr<Cache> open(std::uint64_t limit = kDefaultCacheLimit, CacheUse use = CacheUse::readWrite) {
    auto cache = Cache::open(folder.path / "cache", limit, use);
    EXPECT_TRUE(cache.ok());
    return std::move(cache).value();
  }

  test::TemporaryFolder folder;
};

TEST_F(Caches, GiveBackWhatWasStored) {
  const auto cache = open();
  EXPECT_FALSE(cache->entry(keyOf("a")));
  cache->storeEntry(keyOf("a"), bytesOf("payload"));
  cache->storeEntry(keyOf("b"), {});
  const Bytes content = bytesOf("content");
  cache->storeObject(contentHash(content), content);
  const auto again = open();
  EXPECT_EQ(again->entry(keyOf("a")), bytesOf("payload"));
  EXPECT_EQ(again->entry(keyOf("b")), Bytes{});
  EXPECT_EQ(again->object(contentHash(content), content.size()), content);
  EXPECT_FALSE(again->entry(keyOf("c")));
  EXPECT_THAT(again->takeNotes(), IsEmpty());
}

// Every byte of a file counts: any flip and any cut is found, noted and removed.
TEST_F(Caches, DamageIsFound) {
  const Bytes content = bytesOf("some content");
  for (const bool object : {false, true}) {
    fs::remove_all(folder.path / "cache");
    const auto store = [&](Cache& cache) {
      if (object)
        cache.storeObject(contentHash(content), content);
      else
        cache.storeEntry(keyOf("k"), content);
    };
    const auto load = [&](Cache& cache) { return object ? cache.object(contentHash(content), content.size()) : cache.entry(keyOf("k")); };
    const auto cache = open();
    store(*cache);
    const fs::path file = filesIn(folder.path / "cache/v1").at(0);
    const Bytes whole = readFile(file).value();
    for (std::size_t i = 0; i <= whole.size(); ++i) {
      Bytes damaged(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(i));
      if (i == whole.size()) damaged.push_back(std::byte{0});
      overwrite(file, damaged);
      EXPECT_FALSE(load(*cache)) << "cut to " << i;
      EXPECT_FALSE(fs::exists(file));
      EXPECT_THAT(cache->takeNotes(), ElementsAre(HasSubstr("is damaged"))) << "cut to " << i;
      if (i == whole.size()) break;
      damaged = whole;
      damaged[i] ^= std::byte{4};
      overwrite(file, damaged);
      EXPECT_FALSE(load(*cache)) << "flipped " << i;
      EXPECT_THAT(cache->takeNotes(), ElementsAre(HasSubstr("is damaged")));
    }
    store(*cache);
    EXPECT_EQ(load(*cache), content);
  }
}

TEST_F(Caches, AnEntryUnderAnotherKeyIsDamaged) {
  const auto cache = open();
  cache->storeEntry(keyOf("k"), bytesOf("of k"));
  const fs::path file = filesIn(folder.path / "cache/v1").at(0);
  const std::string other = keyOf("other");
  const fs::path wrong = folder.path / "cache/v1/entries" / other.substr(0, 2) / other.substr(2);
  fs::create_directories(wrong.parent_path());
  fs::copy_file(file, wrong);
  EXPECT_FALSE(cache->entry(other));
  EXPECT_TRUE(cache->entry(keyOf("k")));
}

// What was used last stays; entries outlive the objects they name.
TEST_F(Caches, TrimRemovesWhatWasNotUsedForTheLongestTime) {
  const auto content = [](int i) { return Bytes(1000, static_cast<std::byte>(i)); };
  {
    const auto cache = open();
    for (int i = 0; i < 20; ++i) cache->storeObject(contentHash(content(i)), content(i));
    cache->storeEntry(keyOf("entry"), bytesOf("old"));
  }
  auto age = fs::file_time_type::clock::now() - std::chrono::hours(30);
  for (const fs::path& file : filesIn(folder.path / "cache/v1")) fs::last_write_time(file, age);
  const fs::path torn = folder.path / "cache/v1/objects/.torn.1.1.tmp", fresh = folder.path / "cache/v1/objects/.fresh.1.1.tmp";
  overwrite(torn, bytesOf("x"));
  overwrite(fresh, bytesOf("x"));
  fs::last_write_time(torn, age);
  {
    const auto cache = open(10'000);
    for (const int used : {3, 11, 17}) EXPECT_TRUE(cache->object(contentHash(content(used)), 1000));
    cache->trim();
    std::uint64_t total = 0;
    for (const fs::path& file : filesIn(folder.path / "cache/v1")) total += fs::file_size(file);
    EXPECT_LE(total, 10'000u);
    EXPECT_GE(total, 8'000u);
    for (const int used : {3, 11, 17}) EXPECT_TRUE(cache->object(contentHash(content(used)), 1000)) << used;
    EXPECT_TRUE(cache->entry(keyOf("entry")));
    EXPECT_FALSE(fs::exists(torn));
    EXPECT_TRUE(fs::exists(fresh)) << "another process may be writing it";
  }
}

TEST_F(Caches, StayWithinTheirLimitWhileTheyGrow) {
  const auto cache = open(100'000);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    Bytes content(1000);
    std::memcpy(content.data(), &i, sizeof i);
    cache->storeObject(contentHash(content), content);
  }
  std::uint64_t total = 0;
  for (const fs::path& file : filesIn(folder.path / "cache/v1")) total += fs::file_size(file);
  EXPECT_LE(total, 115'000u);
}

TEST_F(Caches, OnlyReadWhenAsked) {
  { open()->storeEntry(keyOf("k"), bytesOf("v")); }
  const fs::path file = filesIn(folder.path / "cache/v1").at(0);
  const auto time = fs::last_write_time(file);
  const auto cache = open(0, CacheUse::readOnly);
  EXPECT_TRUE(cache->entry(keyOf("k")));
  cache->storeEntry(keyOf("l"), bytesOf("v"));
  EXPECT_FALSE(cache->entry(keyOf("l")));
  EXPECT_EQ(fs::last_write_time(file), time);
  EXPECT_TRUE(Cache::open(folder.path / "none", 0, CacheUse::readOnly).ok());
  EXPECT_FALSE(fs::exists(folder.path / "none"));
}

TEST_F(Caches, RefuseWhatIsNoFolder) {
  overwrite(folder.path / "file", bytesOf("x"));
  for (const char* path : {"file", "file/below"}) EXPECT_FALSE(Cache::open(folder.path / path, 0).ok()) << path;
  EXPECT_FALSE(Cache::open("/proc/overcast-cache", 0).ok());
}

// Writers, readers and trimming in four processes: nobody ever sees wrong bytes.
TEST_F(Caches, AreSharedByProcesses) {
  constexpr int kKeys = 40;
  const auto payload = [](int k) { return Bytes(static_cast<std::size_t>(100 + 50 * k), static_cast<std::byte>(k)); };
  open();
  std::vector<pid_t> children;
  for (int child = 0; child < 4; ++child) {
    const pid_t id = ::fork();
    ASSERT_GE(id, 0);
    if (id > 0) {
      children.push_back(id);
      continue;
    }
    const auto cache = Cache::open(folder.path / "cache", 20'000);
    int wrong = cache.ok() ? 0 : 1;
    for (int i = 0; i < 400 && wrong == 0; ++i) {
      const int k = (i * 7 + child * 13) % kKeys;
      const auto found = cache.value()->entry(keyOf(std::to_string(k)));
      if (found && *found != payload(k)) wrong = 2;
      if (!found) cache.value()->storeEntry(keyOf(std::to_string(k)), payload(k));
      if (i % 40 == child) cache.value()->trim();
    }
    if (wrong == 0 && !cache.value()->takeNotes().empty()) wrong = 3;
    ::_exit(wrong);
  }
  for (const pid_t id : children) {
    int status = 0;
    ASSERT_EQ(::waitpid(id, &status, 0), id);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
  }
}

TEST(KeyLocks, LetOneThreadWorkOnAKey) {
  KeyLocks locks;
  std::atomic<int> inside{0}, most{0}, done{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 50; ++i) {
        const KeyLocks::Lock other(locks, "own " + std::to_string(t));
        const KeyLocks::Lock lock(locks, "shared");
        const int now = ++inside;
        if (now > most) most = now;
        std::this_thread::yield();
        --inside;
        ++done;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(most, 1);
  EXPECT_EQ(done, 400);
}

}  // namespace
}  // namespace overcast
