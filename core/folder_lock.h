// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One writer a folder. Several machines may work on the units of one --out, each unit being a folder, but two
// processes in the same unit would mix their files. The lock is the kernel's (flock, over NFS too): it ends
// with the process that holds it, however that ends.

#include <filesystem>
#include <memory>

#include "core/process.h"

namespace thermotwin::core {

class FolderLock {
public:
  /// Makes the folder if it is missing. A file system without locks is taken as it is, with a warning.
  /// @throws InputError if another process writes there: which, on which host
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  FolderLock& operator=(FolderLock&&) = delete;

private:
  int file_ = -1;
  std::unique_ptr<UnfinishedPath> path_;  ///< the file goes when the lock does
};

/// Removes the lock file that a killed process left in the folder, if there is one.
void remove_stale_lock(const std::filesystem::path& folder);

}  // namespace thermotwin::core
