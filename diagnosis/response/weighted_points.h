// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Channels that are weighted sums e = W d of deviations d at the same points and times, such as the location errors of
// one test. If the errors of d are independent, those of e have the correlation R of W W^T. The sums x = M e with
// M = U R^-1/2 U^-1 and the stated uncertainties U have uncorrelated errors. Of all such sums they are nearest to e.
// The discretisation error rotates and scales the motion of tool against table alike at all points. It changes e by
//   sum_ab s_a f_ab W_a d_b,   a, b = x, y, z,
// with the share s_a, the columns W_a of W and the deviations d_b in direction b. Each factor f_ab has standard
// deviation 1 and is common to all channels of a test. Factors with a != b act only if the share is one of the whole
// motion (MeshAllowance). A common shift of all points hardly affects a rotation, and neither does its mesh error.

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

/// Standard deviations of the sums for independent errors of 1 um of the deviations, (m) um or um/m per um.
Eigen::VectorXd gains_of(const PointTest& test);

struct TestErrors {
  std::vector<Eigen::MatrixXd> joint;  ///< (n x m) of each factor f_ab, channels of the test
  Eigen::VectorXd independent;         ///< (m) RMS of each sum where the shares differ from point to point
};
/// Discretisation errors of a test, from the response of the nominal machine.
TestErrors errors_of(const mesh::Machine& machine, const Observations& observations, const PointTest& test,
                     const Response& response, const MeshAllowance& allowance);

/// The same rows with the sums of each test in place of its channels. @param stacked  (observations x any)
Eigen::MatrixXd with_sums(const std::vector<PointTest>& tests, const Observations& observations,
                          const Eigen::MatrixXd& stacked);

}  // namespace thermotwin::diagnosis
