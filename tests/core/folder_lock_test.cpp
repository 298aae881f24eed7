// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/folder_lock.h"

#include <gtest/gtest.h>

#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::core {
namespace {

TEST(FolderLock, RefusesASecondWriterAndNamesTheFirst) {
  const TemporaryFolder folder;
  const auto unit = folder / "unit";
  {
    const FolderLock first(unit);
    try {
      const FolderLock second(unit);
      FAIL() << "two writers";
    } catch (const InputError& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("process " + std::to_string(::getpid()) + " on "), std::string::npos) << text;
      EXPECT_NE(text.find(unit.string()), std::string::npos) << text;
    }
    const FolderLock other(folder / "other unit");
  }
  EXPECT_FALSE(std::filesystem::exists(unit / "lock"));
  const FolderLock again(unit);
}

TEST(FolderLock, EndsWithAKilledProcess) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    const FolderLock lock(folder / "unit");
    ::kill(::getpid(), SIGKILL);
  }
  ::waitpid(child, nullptr, 0);
  ASSERT_TRUE(std::filesystem::exists(folder / "unit/lock"));
  remove_stale_lock(folder / "unit");
  EXPECT_FALSE(std::filesystem::exists(folder / "unit/lock"));
  const FolderLock again(folder / "unit");
  remove_stale_lock(folder / "unit");
  EXPECT_TRUE(std::filesystem::exists(folder / "unit/lock"));
}

}  // namespace
}  // namespace thermotwin::core
