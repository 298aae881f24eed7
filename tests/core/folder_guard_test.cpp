// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/folder_guard.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::core {
namespace {

namespace fs = std::filesystem;

TEST(FolderGuard, KeepsEveryWriterOutOfALostFolder) {
  const TemporaryFolder folder;
  const fs::path out = folder / "out", beside = folder / "outer";
  write_file(out / "mark", "ours");
  {
    const FolderGuard guard(out / "", out / "mark");
    write_file(out / "a", "before");
    fs::rename(out, folder / "away");
    EXPECT_THROW(write_file(out / "a", ""), InputError);
    EXPECT_THROW(write_file_by(out / "a", [](const fs::path&) {}), InputError);
    EXPECT_THROW(write_files_by(out / "b", [](const fs::path&) { return std::vector<fs::path>{}; }), InputError);
    EXPECT_THROW(FolderLock(out / "unit"), InputError);
    EXPECT_FALSE(fs::exists(out));
    write_file(beside / "a", "not below");
    fs::create_directories(out);
    write_file_or_say(out / "mark", "another");
    EXPECT_FALSE(fs::exists(out / "mark"));
    fs::remove(out);
    fs::rename(folder / "away", out);
    write_file(out / "a", "after");
  }
  fs::remove_all(out);
  write_file(out / "a", "without a guard");
}

}  // namespace
}  // namespace thermotwin::core
