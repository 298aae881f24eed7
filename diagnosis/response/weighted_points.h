// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Channels that are weighted sums of deviations at the same points at the same times: the location errors e = W d of
// one test. With independent errors of the deviations d, those of e have the correlation of W W^T. Sums x = M e are
// free of it, M = U R^-1/2 U^-1 with the correlation R and the stated uncertainties U: of all such sums the nearest to
// the channels themselves. The mesh turns and scales the motion of the tool against the table by one share at all
// points; e then is off by
//   sum_ab s_a f_ab W_a d_b,   a, b = x, y, z,
// with the share s_a, one factor f_ab of standard deviation 1 for all channels of a test, the columns W_a of W and the
// deviations d_b in direction b. A shift of all points alike hardly shows in a rotation, nor does its mesh error.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/record/observations.h"
#include "diagnosis/response/mesh_allowance.h"
#include "diagnosis/response/response.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::diagnosis {

struct PointTest {
  std::vector<std::size_t> channels;  ///< (m) of the observations, with means of the same intervals
  int record = 0;
  std::vector<mesh::Pose> poses;
  Eigen::MatrixXd weights;    ///< (m x 3 poses) of the channels
  Eigen::MatrixXd sums;       ///< (m x m) M
  Eigen::MatrixXd from_sums;  ///< (m x m) its inverse

  Eigen::MatrixXd weights_of_sums() const { return sums * weights; }  ///< (m x 3 poses)
};

/// The tests of the records. A channel whose means are of other intervals is a test of its own.
std::vector<PointTest> tests_of(const mesh::Machine& machine, const Observations& observations);

/// What independent errors of 1 um of the deviations become in the sums. (m) um or um/m per um
Eigen::VectorXd gains_of(const PointTest& test);

struct TestErrors {
  std::vector<Eigen::MatrixXd> joint;  ///< (n x m) of each factor f_ab, channels of the test
  Eigen::VectorXd independent;         ///< (m) RMS of each sum where the shares differ from point to point
};
/// What the mesh adds to a test along the response of the nominal machine.
TestErrors errors_of(const mesh::Machine& machine, const Observations& observations, const PointTest& test,
                     const Response& response, const MeshAllowance& allowance);

/// The same rows with the sums of each test in place of its channels. @param stacked  (observations x any)
Eigen::MatrixXd with_sums(const std::vector<PointTest>& tests, const Observations& observations,
                          const Eigen::MatrixXd& stacked);

}  // namespace thermotwin::diagnosis
