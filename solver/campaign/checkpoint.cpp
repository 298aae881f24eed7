// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/checkpoint.h"

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"

namespace thermotwin::solver {
namespace {
const std::string magic = "thermotwin checkpoint 2\n";
constexpr std::size_t hash_length = 16;

void write_members(core::BinaryWriter& out, const std::vector<std::string>& members) {
  out.count(members.size());
  for (const std::string& member : members) out.text(member);
}

std::vector<std::string> read_members(core::BinaryReader& in) {
  std::vector<std::string> members;
  for (std::int64_t count = in.count(); count > 0; --count) members.push_back(in.text());
  return members;
}

}  // namespace

Checkpoint::Checkpoint(std::filesystem::path path, std::string hash, std::vector<std::string> members,
                       double interval_s, bool resume)
    : path_(std::move(path)),
      hash_(std::move(hash)),
      members_(std::move(members)),
      interval_s_(interval_s),
      resume_(resume) {}

bool Checkpoint::due() const {
  return !last_ || std::chrono::duration<double>(std::chrono::steady_clock::now() - *last_).count() >= interval_s_;
}

void Checkpoint::write(const std::function<void(core::BinaryWriter&)>& save) {
  core::BinaryWriter out;
  write_members(out, members_);
  save(out);
  if (save_rest) save_rest(out);
  core::write_file(path_, magic + hash_ + core::content_hash(out.bytes()) + out.bytes());
  last_ = std::chrono::steady_clock::now();
}

std::optional<std::string> Checkpoint::read() const {
  if (!resume_ || !std::filesystem::exists(path_)) return std::nullopt;
  std::string bytes;
  try {
    bytes = core::read_file(path_);
  } catch (const core::InputError& error) {
    core::warn(std::string(error.what()) + "; the run restarts from the beginning");
    return std::nullopt;
  }
  const std::size_t header = magic.size() + 2 * hash_length;
  if (bytes.size() < header || bytes.compare(0, magic.size(), magic) != 0) {
    core::warn(path_.string() + " is no checkpoint of this version; the run restarts from the beginning");
    return std::nullopt;
  }
  if (bytes.compare(magic.size(), hash_length, hash_) != 0) {
    core::warn(path_.string() +
               " belongs to another machine, mesh, load or options; the run restarts from the beginning");
    return std::nullopt;
  }
  const std::string sum = bytes.substr(magic.size() + hash_length, hash_length);
  bytes.erase(0, header);
  if (core::content_hash(bytes) != sum) {
    core::warn(path_.string() + " is damaged; the run restarts from the beginning");
    return std::nullopt;
  }
  return bytes;
}

bool Checkpoint::restore(const std::function<void(core::BinaryReader&)>& load) {
  const std::optional<std::string> bytes = read();
  if (!bytes) return false;
  core::BinaryReader in(*bytes, path_.string());
  read_members(in);
  load(in);
  if (load_rest) load_rest(in);
  return true;
}

std::optional<Checkpoint::Owner> Checkpoint::owner(const std::filesystem::path& path) {
  try {
    const std::string bytes = core::read_file(path);
    const std::size_t header = magic.size() + 2 * hash_length;
    if (bytes.size() < header || bytes.compare(0, magic.size(), magic) != 0) return std::nullopt;
    core::BinaryReader in(std::string_view(bytes).substr(header), path.string());
    return Owner{bytes.substr(magic.size(), hash_length), read_members(in)};
  } catch (const core::InputError&) {
    return std::nullopt;
  }
}

void Checkpoint::remove() const {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace thermotwin::solver
