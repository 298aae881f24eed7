// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// States of a run, kept in a file until the run is complete, so that a stopped run finds them again; without a file, in
// memory.

#include <Eigen/Core>

#include <filesystem>
#include <fstream>

namespace thermotwin::solver {

class StateSpool {
public:
  /// @param path  empty: memory
  StateSpool(std::filesystem::path path, Eigen::Index size, Eigen::Index states);

  /// States come in order; a resumed run may write the last ones again.
  /// @throws InputError if the file cannot be written
  void put(Eigen::Index index, const Eigen::Ref<const Eigen::VectorXd>& state);
  /// All that was written is in the file. @throws InputError if it cannot be
  void flush();
  /// Goes on with the file of a stopped run. @param states  that its checkpoint counts on
  /// @throws InputError if the file is missing or holds fewer
  void reopen(Eigen::Index states);
  /// @return (size x states)  @throws InputError if the file cannot be read back
  Eigen::MatrixXd take(Eigen::Index states);
  void discard() const;

private:
  std::filesystem::path path_;
  Eigen::Index size_;
  std::fstream file_;
  Eigen::MatrixXd memory_;
};

}  // namespace thermotwin::solver
