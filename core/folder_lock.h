// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Allows one writing process per folder. Several computers may work on one --out, each in the folder of its own unit.
// Two processes in one folder would mix their files. The kernel's lock (flock, also over NFS) ends with the process
// that holds it.

#include <filesystem>
#include <memory>

#include "core/process.h"

namespace thermotwin::core {

class FolderLock {
public:
  /// Creates the folder if it is missing. On a file system without locks it warns and continues without one.
  /// @throws InputError if the folder is not writable, or another process writes there (with its number and host)
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
