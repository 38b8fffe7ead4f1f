#include "formats/files.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <set>
#include <span>
#include <thread>

#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;
using test::entries;
using test::spill;
using test::TemporaryFolder;

std::string slurp(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string asText(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(Files, WhatIsWrittenIsReadBack) {
  const TemporaryFolder folder;
  const std::string all = std::string("zero \0 and \xff and \r\n", 18);
  for (const std::string& text : {std::string(), all, std::string(3 << 20, 'x')}) {
    const fs::path path = folder.path / "new" / "folders" / "file.bin";
    ASSERT_TRUE(writeFileAtomically(path, text).ok());
    EXPECT_EQ(slurp(path), text);
    const auto read = readFile(path);
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(asText(read.value()), text);
    EXPECT_EQ(entries(path.parent_path()), 1u) << "a temporary file was left";
  }
}

TEST(Files, AReplacedFileKeepsItsPermissions) {
  const TemporaryFolder folder;
  const fs::path path = folder.path / "file";
  spill(path, "old");
  ASSERT_EQ(::chmod(path.c_str(), 0640), 0);
  ASSERT_TRUE(writeFileAtomically(path, std::string_view("new")).ok());
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0640u);
}

TEST(Files, AFullDiskLeavesTheOldFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.path / "file";
  spill(path, "old");
  // A limit on the size of files stands in for a full disk: write() stops short, then fails.
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = ::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{100'000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto written = writeFileAtomically(path, std::string(200'000, 'x'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  ::signal(SIGXFSZ, handler);
  ASSERT_FALSE(written.ok());
  EXPECT_NE(message(written.error()).find(path.string()), std::string::npos);
  EXPECT_EQ(slurp(path), "old");
  EXPECT_EQ(entries(folder.path), 1u);
}

TEST(Files, AFolderThatCannotBeWrittenIsAnError) {
  const TemporaryFolder folder;
  spill(folder.path / "file", "old");
  EXPECT_FALSE(writeFileAtomically(folder.path / "file" / "below", std::string_view("x")).ok());  // holds for root too
  EXPECT_FALSE(writeFileAtomically("/proc/overcast-test", std::string_view("x")).ok());
  EXPECT_EQ(slurp(folder.path / "file"), "old");
  if (::geteuid() == 0) return;  // root writes to read-only folders
  ASSERT_EQ(::chmod(folder.path.c_str(), 0555), 0);
  const auto written = writeFileAtomically(folder.path / "file", std::string_view("new"));
  ASSERT_EQ(::chmod(folder.path.c_str(), 0755), 0);
  EXPECT_FALSE(written.ok());
  EXPECT_EQ(slurp(folder.path / "file"), "old");
}

TEST(Files, WhetherAFolderCanBeWrittenIsKnownBeforeAndLeavesNothing) {
  const TemporaryFolder folder;
  spill(folder.path / "file", "old");
  EXPECT_TRUE(checkWritable(folder.path).ok());
  EXPECT_TRUE(checkWritable(folder.path / "new" / "deep").ok());
  EXPECT_TRUE(checkWritable("").ok());
  EXPECT_TRUE(checkWritable("not-there").ok());
  for (const fs::path& wrong : {folder.path / "file", folder.path / "file" / "below", fs::path("/proc/overcast-test")}) {
    const auto checked = checkWritable(wrong);
    ASSERT_FALSE(checked.ok()) << wrong;
    EXPECT_NE(message(checked.error()).find(wrong == folder.path / "file" / "below" ? "file" : wrong.string()), std::string::npos);
  }
  EXPECT_EQ(entries(folder.path), 1u);
}

TEST(Files, TheHashOfAFileIsThatOfItsBytes) {
  const TemporaryFolder folder;
  for (const std::size_t size : {0u, 1u, 1000u, 1u << 18, (1u << 18) + 1u, 1'000'000u}) {
    std::string text(size, 'x');
    for (std::size_t i = 0; i < size; i += 7) text[i] = static_cast<char>(i * i / 3);
    spill(folder.path / "file", text);
    const auto hash = fileHash(folder.path / "file");
    ASSERT_TRUE(hash.ok());
    EXPECT_EQ(hash.value(), contentHash(std::as_bytes(std::span(text)))) << size;
  }
  EXPECT_FALSE(fileHash(folder.path / "missing").ok());
  EXPECT_FALSE(fileHash(folder.path).ok());
}

TEST(Files, UnsyncedFilesAreWholeToo) {
  const TemporaryFolder folder;
  const std::string text(100'000, 'y');
  ASSERT_TRUE(writeFileAtomically(folder.path / "file", std::as_bytes(std::span(text)), Durability::unsynced).ok());
  EXPECT_EQ(slurp(folder.path / "file"), text);
  EXPECT_EQ(entries(folder.path), 1u);
}

TEST(Files, AFolderInTheWayIsAnErrorAndLeavesNothing) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path / "taken");
  EXPECT_FALSE(writeFileAtomically(folder.path / "taken", std::string_view("x")).ok());
  EXPECT_EQ(entries(folder.path), 1u);
  EXPECT_FALSE(writeFileAtomically(folder.path / "taken" / "", std::string_view("x")).ok());
}

TEST(Files, ConcurrentWritersLeaveOneWholeFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.path / "file";
  std::set<std::string> candidates;
  for (char c = 'a'; c < 'i'; ++c) candidates.insert(std::string(100'000, c));
  std::vector<std::thread> writers;
  for (const std::string& text : candidates) {
    writers.emplace_back([&] {
      for (int i = 0; i < 5; ++i) EXPECT_TRUE(writeFileAtomically(path, text).ok());
    });
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(candidates.count(slurp(path)), 1u);
  EXPECT_EQ(entries(folder.path), 1u);
}

TEST(Files, AKilledWriterLeavesTheOldFileOrTheNew) {
  const TemporaryFolder folder;
  const fs::path path = folder.path / "file";
  const std::string a(2 << 20, 'a'), b(2 << 20, 'b');
  ASSERT_TRUE(writeFileAtomically(path, a).ok());
  for (useconds_t pause = 1000; pause < 20'000; pause += 1700) {
    const pid_t writer = ::fork();
    if (writer == 0) {
      for (;;) {
        if (!writeFileAtomically(path, b).ok() || !writeFileAtomically(path, a).ok()) ::_exit(1);
      }
    }
    ::usleep(pause);
    ::kill(writer, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(writer, &status, 0), writer);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the writer failed before it was killed";
    const std::string left = slurp(path);
    EXPECT_TRUE(left == a || left == b) << "torn: " << left.size() << " bytes";
  }
}

TEST(Files, WhatCannotBeReadIsAnErrorThatNamesTheFile) {
  const TemporaryFolder folder;
  spill(folder.path / "ten", "0123456789");
  ASSERT_EQ(::mkfifo((folder.path / "pipe").c_str(), 0600), 0);
  for (const char* name : {"missing", ".", "pipe"}) {
    const auto read = readFile(folder.path / name);
    ASSERT_FALSE(read.ok()) << name;
    EXPECT_EQ(read.error().file, (folder.path / name).string());
    EXPECT_EQ(message(read.error()).find('\n'), std::string::npos);
  }
  EXPECT_TRUE(readFile(folder.path / "ten", 10).ok());
  EXPECT_FALSE(readFile(folder.path / "ten", 9).ok());
}

TEST(Files, ContentHashIsXxh3) {
  // Published check value of XXH3_128bits for no input (xxHash's own sanity checks).
  EXPECT_EQ(contentHash({}), "99aa06d3014798d86001c324468d497f");
  const std::vector<std::byte> a(1000, std::byte{1});
  std::vector<std::byte> b = a;
  EXPECT_EQ(contentHash(a), contentHash(b));
  b[999] = std::byte{2};
  EXPECT_NE(contentHash(a), contentHash(b));
  EXPECT_EQ(contentHash(b).size(), 32u);
}

TEST(ResolveInside, AcceptsWhatLiesBelow) {
  const TemporaryFolder folder;
  const auto resolved = [&](std::string_view uri) { return resolveInside(folder.path, uri); };
  const std::pair<const char*, const char*> cases[] = {{"a.bin", "a.bin"},
                                                       {"sub/a.bin", "sub/a.bin"},
                                                       {"sub/../a.bin", "a.bin"},
                                                       {"with%20space.bin", "with space.bin"},
                                                       {"./a.bin", "a.bin"},
                                                       {"..a/b", "..a/b"},
                                                       {"sub/time%3A12.bin", "sub/time:12.bin"},
                                                       {"a%2Fb.bin", "a/b.bin"}};
  for (const auto& [uri, expected] : cases) {
    const auto path = resolved(uri);
    ASSERT_TRUE(path.ok()) << uri << " " << message(path.error());
    EXPECT_EQ(path.value(), folder.path / expected);
  }
  EXPECT_TRUE(resolveInside("", "a.bin").ok());
}

TEST(ResolveInside, RefusesWhatLeaves) {
  const TemporaryFolder folder;
  const std::string zero("a\0.bin", 6);
  for (const std::string_view uri :
       {std::string_view(""), std::string_view("/etc/passwd"), std::string_view("%2Fetc/passwd"), std::string_view("../a"),
        std::string_view("sub/../../a"), std::string_view("%2e%2e/a"), std::string_view("..%2fa"), std::string_view(".."),
        std::string_view("."), std::string_view("sub/"), std::string_view("file:///etc/passwd"), std::string_view("data:,x"),
        std::string_view("http://example.org/a"), std::string_view("..\\a"), std::string_view("a%00.bin"), std::string_view(zero),
        std::string_view("bad%zz"), std::string_view("bad%2"), std::string_view("sub/..")}) {
    const auto path = resolveInside(folder.path, uri);
    ASSERT_FALSE(path.ok()) << uri;
    EXPECT_EQ(message(path.error()).find('\n'), std::string::npos);
  }
}

TEST(ResolveInside, RefusesSymbolicLinksThatLeave) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path / "asset" / "sub");
  spill(folder.path / "secret", "x");
  spill(folder.path / "asset" / "sub" / "fine", "x");
  fs::create_symlink("../secret", folder.path / "asset" / "link");
  fs::create_symlink("..", folder.path / "asset" / "up");
  fs::create_symlink("sub/fine", folder.path / "asset" / "inside");
  EXPECT_FALSE(resolveInside(folder.path / "asset", "link").ok());
  EXPECT_FALSE(resolveInside(folder.path / "asset", "up/secret").ok());
  EXPECT_FALSE(resolveInside(folder.path / "asset", "up/not-there-yet").ok());
  EXPECT_TRUE(resolveInside(folder.path / "asset", "inside").ok());
  // The folder itself may be reached through a link.
  fs::create_directory_symlink("asset", folder.path / "alias");
  EXPECT_TRUE(resolveInside(folder.path / "alias", "sub/fine").ok());
}

}  // namespace
}  // namespace overcast
