// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Temperatures of many loads as a few modes (field_modes.h) and, for each load, the times and coefficients of at most
// `most_times` of its outputs: small enough for a page, whatever the campaign's size.

#include <map>
#include <string>
#include <vector>

#include "solver/export/field_modes.h"

namespace thermotwin::solver {

/// At most this many rows of `count`, evenly spread, the first and the last among them.
std::vector<Eigen::Index> thinned(Eigen::Index count, Eigen::Index most);

class FieldRecord {
public:
  static constexpr Eigen::Index most_times = 72;
  explicit FieldRecord(Eigen::Index modes) : modes_(modes) {}

  /// Takes the state of an output if it is one of those that are kept. @param of  outputs of the load
  void add(const std::string& load, Eigen::Index output, Eigen::Index of,
           const Eigen::Ref<const Eigen::VectorXd>& state);

  /// Where modes and coefficients are final. No further add().
  void close();
  bool empty() const { return result_.modes.cols() == 0; }
  const Eigen::MatrixXd& modes() const { return result_.modes; }  ///< (size x modes)
  /// (modes x thinned times); no columns where not all of the load's times were seen.
  Eigen::MatrixXd coefficients(const std::string& load, Eigen::Index of) const;

private:
  FieldModes modes_;
  FieldModes::Result result_;
  std::map<std::string, std::map<Eigen::Index, Eigen::Index>> numbers_;  ///< by load and output: of the state
};

}  // namespace thermotwin::solver
