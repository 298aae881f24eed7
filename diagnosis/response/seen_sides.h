// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What channels and poses show of the motions of the tool side and the table side, which reduction::side_rows has for
// a state of the model.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/record/observations.h"
#include "mesh/machine/kinematics.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::diagnosis {

/// What is seen of the 19 rows of reduction::side_rows at a pose, by a function of the TCP error there.
/// @param seen  (TcpError) -> values, um or um/m
template <class Seen>
Eigen::MatrixXd sides_at(const mesh::Machine& machine, const mesh::Pose& pose, Eigen::Index values, const Seen& seen) {
  const Eigen::Matrix<double, 19, 19> unit = Eigen::Matrix<double, 19, 19>::Identity();
  Eigen::MatrixXd sides(values, 19);
  for (Eigen::Index i = 0; i < 19; ++i) {
    sides.col(i) = seen(
        [&](const mesh::Pose& at) {
          return solver::tcp_error(machine, at, unit.col(i).head<6>(), unit.col(i).segment<6>(6),
                                   unit.col(i).tail<7>());
        },
        pose);
  }
  return sides;
}

/// What a displacement channel shows of the 19 rows at poses. The zero is the observation's affair.
struct Sides {
  std::vector<mesh::Pose> poses;
  std::vector<Eigen::RowVectorXd> rows;  ///< (poses) 19 each
};

/// A channel with points has rows at each of them. Of another, rows at a pose beside its own, which show the growth of
/// the table, are taken as equal to those at the pose.
Sides sides_of(const mesh::Machine& machine, const ObservedChannel& observed);

}  // namespace thermotwin::diagnosis
