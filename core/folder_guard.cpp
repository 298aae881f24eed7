// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/folder_guard.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "core/error.h"
#include "core/file.h"

namespace thermotwin::core {
namespace {

namespace fs = std::filesystem;

struct Guards {
  std::mutex mutex;
  std::vector<const FolderGuard::Guarded*> all;  // guarded by mutex
};

Guards& guards() {
  static Guards instance;
  return instance;
}

fs::path absolute_name(const fs::path& path) {
  const fs::path name = fs::absolute(path).lexically_normal();
  return name.has_filename() ? name : name.parent_path();  // "out/" is "out"
}

bool is_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

bool is_there(const FolderGuard::Guarded& guarded) {
  try {
    return read_file(guarded.mark) == guarded.content;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

FolderGuard::FolderGuard(const fs::path& folder, const fs::path& mark)
    : guarded_{absolute_name(folder), absolute_name(mark), read_file(mark)} {
  const std::lock_guard lock(guards().mutex);
  guards().all.push_back(&guarded_);
}

FolderGuard::~FolderGuard() {
  const std::lock_guard lock(guards().mutex);
  std::erase(guards().all, &guarded_);
}

void require_not_lost(const fs::path& path) {
  const std::lock_guard lock(guards().mutex);
  if (guards().all.empty()) return;
  const fs::path written = absolute_name(path);
  for (const FolderGuard::Guarded* guarded : guards().all) {
    if (!is_below(written, guarded->folder) || is_there(*guarded)) continue;
    throw InputError(guarded->folder.string(),
                     "the folder has gone away: " + guarded->mark.string() + " is missing or another",
                     "the folder in which the work began; mount it or undo its renaming, and start again. Nothing was "
                     "written in its place, and what is finished is kept");
  }
}

}  // namespace thermotwin::core
