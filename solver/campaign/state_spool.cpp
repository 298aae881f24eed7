// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/state_spool.h"

#include <utility>

#include "core/error.h"

namespace thermotwin::solver {

using Eigen::Index;

namespace {
constexpr auto both_ways = std::ios::binary | std::ios::in | std::ios::out;
}

StateSpool::StateSpool(std::filesystem::path path, Index size, Index states) : path_(std::move(path)), size_(size) {
  if (path_.empty()) memory_.resize(size, states);
}

void StateSpool::put(Index index, const Eigen::Ref<const Eigen::VectorXd>& state) {
  if (path_.empty()) {
    memory_.col(index) = state;
    return;
  }
  if (!file_.is_open()) {
    std::filesystem::create_directories(path_.parent_path());
    if (index == 0) std::ofstream(path_, std::ios::binary | std::ios::trunc).close();
    file_.open(path_, both_ways);
  }
  file_.seekp(index * size_ * sizeof(double));
  file_.write(reinterpret_cast<const char*>(state.data()), size_ * sizeof(double));
  if (!file_) throw core::InputError(path_.string(), "cannot be written", "a folder with free space and permission");
}

void StateSpool::flush() {
  if (file_.is_open() && !file_.flush())
    throw core::InputError(path_.string(), "cannot be written", "a folder with free space and permission");
}

void StateSpool::reopen(Index states) {
  if (path_.empty() || states == 0) return;
  const std::uintmax_t needed = states * size_ * sizeof(double);
  std::error_code error;
  if (const auto there = std::filesystem::file_size(path_, error); error || there < needed) {
    throw core::InputError(path_.string(), "missing or too short for its checkpoint",
                           "both files as the run left them");
  }
  file_.open(path_, both_ways);
}

Eigen::MatrixXd StateSpool::take(Index states) {
  if (path_.empty()) return std::move(memory_);
  file_.flush();
  Eigen::MatrixXd read(size_, states);
  file_.seekg(0);
  file_.read(reinterpret_cast<char*>(read.data()), read.size() * sizeof(double));
  if (!file_) throw core::InputError(path_.string(), "cannot be read back", "the file as it was written");
  file_.close();
  return read;
}

void StateSpool::discard() const {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove(path_, ignored);
}

}  // namespace thermotwin::solver
