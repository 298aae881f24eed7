// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Keeps writers out of a folder that has gone away: a share that is no longer mounted, a parent that was renamed.
// Writers make missing folders, so without a guard they would make the lost path anew, perhaps on another disk.

#include <filesystem>
#include <string>

namespace thermotwin::core {

/// While it lives, nothing of core/file.h or core/folder_lock.h writes below the folder unless its mark is still there
/// with the content that it had at the beginning.
class FolderGuard {
public:
  /// @param folder  that is guarded
  /// @param mark    a file in it that nobody changes  @throws InputError if it cannot be read
  FolderGuard(const std::filesystem::path& folder, const std::filesystem::path& mark);
  ~FolderGuard();
  FolderGuard(const FolderGuard&) = delete;
  FolderGuard& operator=(const FolderGuard&) = delete;

  struct Guarded {
    std::filesystem::path folder, mark;  // absolute
    std::string content;
  };

private:
  const Guarded guarded_;
};

/// For a writer, before it makes or writes the path. @throws InputError if a guarded folder above it has gone away
void require_not_lost(const std::filesystem::path& path);

}  // namespace thermotwin::core
