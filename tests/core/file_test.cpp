// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>
#include <sys/mount.h>
#include <unistd.h>

#include "core/error.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::core {
namespace {

namespace fs = std::filesystem;

std::size_t file_count(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

TEST(File, WritesWhatIsReadAgain) {
  const TemporaryFolder folder;
  const std::string text("a\0b\xFF\n", 5);
  write_file(folder / "new/deep/file.bin", text);
  EXPECT_EQ(read_file(folder / "new/deep/file.bin"), text);
  write_file(folder / "new/deep/file.bin", "");
  EXPECT_EQ(read_file(folder / "new/deep/file.bin"), "");
  EXPECT_EQ(file_count(folder / "new/deep"), 1U);
}

TEST(File, ReadsLargeFilesAndFilesOfUnknownSize) {
  const TemporaryFolder folder;
  std::string text(3000001, 'x');
  text.back() = 'y';
  write_file(folder / "large", text);
  EXPECT_EQ(read_file(folder / "large"), text);
  EXPECT_FALSE(read_file("/proc/self/status").empty());
}

TEST(File, UnreadableIsAnInputError) {
  const TemporaryFolder folder;
  EXPECT_THROW(read_file(folder / "none"), InputError);
  EXPECT_THROW(read_file(folder.path()), InputError);
}

TEST(File, EarlierFileStaysWhenTheWriterFails) {
  const TemporaryFolder folder;
  write_file(folder / "model.rom.h5", "before");
  fs::path used;
  EXPECT_THROW(write_file_by(folder / "model.rom.h5",
                             [&](const fs::path& temporary) {
                               used = temporary;
                               std::ofstream(temporary) << "half";
                               throw SolverError("stopped");
                             }),
               SolverError);
  EXPECT_EQ(read_file(folder / "model.rom.h5"), "before");
  EXPECT_EQ(file_count(folder.path()), 1U) << "the temporary file is removed";
  EXPECT_EQ(used.extension(), ".h5");
  EXPECT_EQ(used.parent_path(), folder.path());
  EXPECT_NE(used.filename(), "model.rom.h5");
}

TEST(File, WriterThatWritesNothingIsAnError) {
  const TemporaryFolder folder;
  write_file(folder / "a.vtu", "before");
  EXPECT_THROW(write_file_by(folder / "a.vtu", [](const fs::path&) {}), InputError);
  EXPECT_EQ(read_file(folder / "a.vtu"), "before");
}

TEST(File, WriterReplacesTheFile) {
  const TemporaryFolder folder;
  write_file(folder / "a.vtu", "before");
  write_file_by(folder / "a.vtu", [](const fs::path& temporary) { std::ofstream(temporary) << "after"; });
  EXPECT_EQ(read_file(folder / "a.vtu"), "after");
  EXPECT_EQ(file_count(folder.path()), 1U);
}

std::vector<fs::path> write_both(const fs::path& staged, const std::string& text) {
  write_file(staged / "deep/table.csv", text);
  write_file(staged / "done", text);
  return {"deep/table.csv", "done"};
}

TEST(Files, ThatBelongTogetherAreReplacedTogether) {
  const TemporaryFolder folder;
  const fs::path results = folder / "results";
  write_file(results / "other", "before");
  write_files_by(results, [](const fs::path& staged) { return write_both(staged, "first"); });
  write_files_by(results, [&](const fs::path& staged) {
    EXPECT_EQ(read_file(results / "done"), "first") << "the earlier ones stay while the new ones are made";
    return write_both(staged, "second");
  });
  EXPECT_EQ(read_file(results / "deep/table.csv"), "second");
  EXPECT_EQ(read_file(results / "done"), "second");
  EXPECT_EQ(read_file(results / "other"), "before");
  EXPECT_EQ(file_count(results), 3U);
}

TEST(Files, ThatBelongTogetherStayWhenTheWriterFails) {
  const TemporaryFolder folder;
  write_files_by(folder.path(), [](const fs::path& staged) { return write_both(staged, "before"); });
  const std::string message = message_of<InputError>([&] {
    write_files_by(folder.path(), [](const fs::path& staged) -> std::vector<fs::path> {
      write_both(staged, "after");
      throw InputError((staged / "third.csv").string(), "cannot be written", "room");
    });
  });
  EXPECT_EQ(message, (folder / "third.csv").string() + ": cannot be written; allowed: room");
  EXPECT_EQ(read_file(folder / "deep/table.csv"), "before");
  EXPECT_EQ(read_file(folder / "done"), "before");
  EXPECT_EQ(file_count(folder.path()), 2U) << "nothing is left of the attempt";
}

// A stop between two of the renames must not leave a mark that vouches for a mixture.
TEST(Files, TheLastOneIsGoneWhileTheOthersMove) {
  const TemporaryFolder folder;
  write_files_by(folder.path(), [](const fs::path& staged) { return write_both(staged, "before"); });
  EXPECT_THROW(write_files_by(folder.path(),
                              [](const fs::path& staged) -> std::vector<fs::path> {
                                write_both(staged, "after");
                                return {"deep/table.csv", "promised, never written", "done"};
                              }),
               InputError);
  EXPECT_EQ(read_file(folder / "deep/table.csv"), "after");
  EXPECT_FALSE(fs::exists(folder / "done"));
}

TEST(File, LinkSurvives) {
  const TemporaryFolder folder;
  write_file(folder / "target.csv", "before");
  fs::create_symlink(folder / "target.csv", folder / "link.csv");
  write_file(folder / "link.csv", "after");
  EXPECT_TRUE(fs::is_symlink(folder / "link.csv"));
  EXPECT_EQ(read_file(folder / "target.csv"), "after");
}

TEST(File, FolderIsNoFile) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_file(folder.path(), "x"), InputError);
  EXPECT_THROW(write_file_by(folder.path(), [](const fs::path&) {}), InputError);
  write_file(folder / "file", "x");
  EXPECT_THROW(write_file(folder / "file/inside", "x"), InputError) << "a file where a folder should be";
}

TEST(File, DevicesAreWrittenInPlace) {
  write_file("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "/dev/full is not there";
  const std::string message = message_of<InputError>([] { write_file("/dev/full", "x"); });
  EXPECT_NE(message.find("/dev/full"), std::string::npos) << message;
  EXPECT_NE(message.find("disk full"), std::string::npos) << message;
}

TEST(File, FullDiskLeavesTheEarlierFile) {
  const TemporaryFolder folder;
  if (::mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=64k") != 0) {
    GTEST_SKIP() << "a small tmpfs cannot be mounted (needs root)";
  }
  struct Unmount {
    const fs::path& path;
    ~Unmount() { ::umount2(path.c_str(), MNT_DETACH); }
  } const unmount{folder.path()};
  write_file(folder / "result.csv", "before");
  const std::string message =
      message_of<InputError>([&] { write_file(folder / "result.csv", std::string(1000000, 'x')); });
  EXPECT_NE(message.find("result.csv"), std::string::npos) << message;
  EXPECT_NE(message.find("disk full"), std::string::npos) << message;
  EXPECT_EQ(read_file(folder / "result.csv"), "before");
  EXPECT_EQ(file_count(folder.path()), 1U);
}

TEST(ContentHash, IsFnv1a) {
  // Published test vectors of the FNV authors.
  EXPECT_EQ(content_hash(""), "cbf29ce484222325");
  EXPECT_EQ(content_hash("a"), "af63dc4c8601ec8c");
  EXPECT_EQ(content_hash("foobar"), "85944171f73967e8");
}

}  // namespace
}  // namespace thermotwin::core
