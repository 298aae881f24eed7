// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "core/character.h"
#include "core/error.h"
#include "core/folder_guard.h"
#include "core/process.h"

namespace thermotwin::core {
namespace {

namespace fs = std::filesystem;

std::string why(int error_number) {
  if (error_number == ENOSPC || error_number == EDQUOT) return "disk full";
  return std::generic_category().message(error_number);
}

[[noreturn]] void fail(const fs::path& path, const std::string& what, int error_number) {
  if (what != "read") require_not_lost(path);  // the reason, if it went away meanwhile
  throw InputError(
      path.string(), fmt::format("cannot be {}: {}", what, why(error_number)),
      what == "read" ? "an existing file with read permission" : "a folder with free space and write permission");
}

/// A file descriptor that closes itself; close() tells whether that went well.
class Descriptor {
public:
  Descriptor(const fs::path& path, int flags) : number_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  bool close() {
    const int number = number_;
    number_ = -1;
    return ::close(number) == 0;
  }

private:
  int number_;
};

/// Waits until the data is on the disk: some file systems report a full disk only here.
void synchronise(const Descriptor& file, const fs::path& path) {
  // Pipes and terminals cannot be synchronised, which is no error.
  if (::fsync(file.number()) != 0 && errno != EINVAL && errno != EROFS && errno != ENOTSUP) {
    fail(path, "written", errno);
  }
}

void write_all(const fs::path& path, const fs::path& name_in_messages, std::string_view text) {
  Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
  if (file.number() < 0) fail(name_in_messages, "written", errno);
  while (!text.empty()) {
    const ssize_t written = ::write(file.number(), text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(name_in_messages, "written", errno);
    text.remove_prefix(written);
  }
  synchronise(file, name_in_messages);
  if (!file.close()) fail(name_in_messages, "written", errno);
}

void make_folder_of(const fs::path& path) {
  require_not_lost(path);
  const fs::path folder = path.parent_path();
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(folder, "made", error.value());
}

/// The file that a link stands for, so that the link survives the rename.
fs::path without_links(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path target = fs::canonical(path, error);
  return error ? path : target;
}

/// A device or pipe (/dev/stdout) is written as it is: a rename would replace it.
bool is_special(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error) && !fs::is_regular_file(path, error);
}

void rename_to(const fs::path& temporary, const fs::path& path) {
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail(path, "written", errno);
}

}  // namespace

std::string read_file(const fs::path& path) {
  const Descriptor file(path, O_RDONLY);
  if (file.number() < 0) fail(path, "read", errno);
  std::string text;
  struct stat status {};
  if (::fstat(file.number(), &status) == 0 && S_ISREG(status.st_mode)) {
    text.reserve(status.st_size + 1);
  }
  std::size_t size = 0;
  for (;;) {
    // One byte more than the file holds finds its end without a second, large buffer.
    text.resize(std::max(text.capacity(), size + 65536));
    const ssize_t count = ::read(file.number(), text.data() + size, text.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(path, "read", errno);
    if (count == 0) break;
    size += count;
  }
  text.resize(size);
  return text;
}

void write_file(const fs::path& path, std::string_view text) {
  const fs::path target = without_links(path);
  if (is_special(target)) {
    write_all(target, path, text);
    return;
  }
  make_folder_of(target);
  const UnfinishedPath temporary(target);
  write_all(temporary.path(), path, text);
  rename_to(temporary.path(), target);
}

std::string write_file_or_say(const fs::path& path, const std::string& text) {
  try {
    write_file(path, text);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

void write_file_by(const fs::path& path, const std::function<void(const fs::path& temporary)>& writer) {
  const fs::path target = without_links(path);
  if (is_special(target)) {
    throw InputError(path.string(), "not a file", "a new file or one that may be replaced");
  }
  make_folder_of(target);
  const UnfinishedPath temporary(target);
  writer(temporary.path());
  {
    Descriptor file(temporary.path(), O_RDONLY);
    if (file.number() < 0) fail(path, "written", errno);
    synchronise(file, path);
  }
  rename_to(temporary.path(), target);
}

void write_files_by(const fs::path& folder,
                    const std::function<std::vector<fs::path>(const fs::path& staged)>& writer) {
  require_not_lost(folder);
  // Within the folder, so that moving the files is no copy.
  const UnfinishedPath staged(folder / "");
  std::error_code error;
  fs::remove_all(staged.path(), error);
  fs::create_directories(staged.path(), error);
  if (error) fail(staged.path(), "made", error.value());
  std::vector<fs::path> files;
  try {
    files = writer(staged.path());
  } catch (const InputError& failure) {
    // The user knows the file by the name that it was to have.
    std::string message = failure.what();
    if (const auto at = message.find(staged.path().string()); at != std::string::npos)
      message.replace(at, staged.path().string().size(), folder.string());
    throw InputError(message);
  }
  if (files.empty()) return;
  const auto together = keep_from_leaving();
  fs::remove(folder / files.back(), error);
  if (error) fail(folder / files.back(), "replaced", error.value());
  for (const fs::path& file : files) {
    make_folder_of(folder / file);
    rename_to(staged.path() / file, folder / file);
  }
}

std::string content_hash(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char byte : bytes) {
    hash ^= byte_of(byte);
    hash *= 0x100000001b3ULL;
  }
  return fmt::format("{:016x}", hash);
}

}  // namespace thermotwin::core
