// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Allows one writing process per folder. Several machines may work on the units of one --out, each of them a folder,
// but two processes in the same unit would mix their files. The lock is that of the kernel (flock, also over NFS) and
// ends with the process that holds it.

#include <filesystem>
#include <memory>

#include "core/process.h"

namespace thermotwin::core {

class FolderLock {
public:
  /// Creates the folder if it is missing. On a file system without locks it warns and continues without one.
  /// @throws InputError if another process writes there, with its number and host
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  FolderLock& operator=(FolderLock&&) = delete;

private:
  int file_ = -1;
  std::unique_ptr<UnfinishedPath> path_;  ///< removes the file together with the lock
};

/// Removes the lock file that a killed process left in the folder, if there is one.
void remove_stale_lock(const std::filesystem::path& folder);

}  // namespace thermotwin::core
