// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Location errors of the rotary axes and of the table over the program, with the names of ISO 230-1: X0C is the shift
// of axis C along X, A0C its rotation about X, R0T the radial growth of the table. All axes are at home.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/evaluation/reduced_models.h"
#include "nc/prediction/prediction.h"

namespace thermotwin::nc {

class LocationErrors {
public:
  /// Location errors of one axis, or of the table (T).
  struct Group {
    std::string of;
    std::vector<std::string> names;  ///< shifts, then rotations
    Eigen::Index first = 0;          ///< of them, among all
  };
  /// @param machine  must outlive this
  explicit LocationErrors(const mesh::Machine& machine);

  std::string header() const;  ///< of locations.csv
  /// @param time  s, of a row that the field still has  @return its row of locations.csv
  std::string add(const ErrorField& field, double time);

  const std::vector<Group>& groups() const { return groups_; }
  /// At most 1600 moments; of a longer program every second, fourth, ... row.
  const std::vector<double>& times() const { return times_; }             ///< s
  const std::vector<Eigen::VectorXd>& values() const { return values_; }  ///< (times) um and um/m

private:
  std::vector<Group> groups_;
  std::vector<compensation::ObservedQuantity> quantities_;
  std::vector<double> times_;
  std::vector<Eigen::VectorXd> values_;
  long rows_ = 0, stride_ = 1;
};

/// Section of the page: a pair of pictures for each axis and the table.
std::string location_section(const LocationErrors& errors);

}  // namespace thermotwin::nc
