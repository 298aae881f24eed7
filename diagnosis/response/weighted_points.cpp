// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/weighted_points.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Channels that say the same twice count as this far from it.
constexpr double least_eigenvalue = 1e-3;

bool same_points(const compensation::MeasuredChannel& a, const compensation::MeasuredChannel& b) {
  return std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                    [](const auto& left, const auto& right) { return left.pose_text == right.pose_text; });
}

bool together(const ObservedChannel& a, const ObservedChannel& b) {
  return a.record == b.record && a.channel.arrangement == b.channel.arrangement && a.channel.zero == b.channel.zero &&
         same_points(a.channel, b.channel) && a.interval == b.interval && a.fitted == b.fitted &&
         a.samples.isApprox(b.samples);
}

void set_sums(PointTest& test, const Observations& observations) {
  const Index m = std::ssize(test.channels);
  const VectorXd norm = test.weights.rowwise().norm();
  const MatrixXd unit = norm.cwiseInverse().asDiagonal() * test.weights;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit * unit.transpose());
  const VectorXd root = eigen.eigenvalues().cwiseMax(least_eigenvalue).cwiseSqrt();
  VectorXd std(m);
  for (Index k = 0; k < m; ++k) std[k] = observations.channels[test.channels[k]].channel.uncertainty;
  const auto turned = [&](const VectorXd& scale) {
    return MatrixXd(std.asDiagonal() * eigen.eigenvectors() * scale.asDiagonal() * eigen.eigenvectors().transpose() *
                    std.cwiseInverse().asDiagonal());
  };
  test.sums = turned(root.cwiseInverse());
  test.from_sums = turned(root);
}

}  // namespace

std::vector<PointTest> tests_of(const mesh::Machine& machine, const Observations& observations) {
  std::vector<PointTest> tests;
  for (std::size_t k = 0; k < observations.channels.size(); ++k) {
    const ObservedChannel& channel = observations.channels[k];
    if (channel.channel.points.empty()) continue;
    const auto of = std::find_if(tests.begin(), tests.end(), [&](const PointTest& test) {
      return together(observations.channels[test.channels.front()], channel);
    });
    PointTest& test = of == tests.end() ? tests.emplace_back() : *of;
    test.record = channel.record;
    test.channels.push_back(k);
    const Index row = test.weights.rows(), points = std::ssize(channel.channel.points);
    test.weights.conservativeResize(row + 1, 3 * points);
    for (Index i = 0; i < points; ++i) {
      const compensation::PointShare& point = channel.channel.points[i];
      test.weights.row(row).segment<3>(3 * i) = point.weight.transpose();
      if (row == 0) test.poses.push_back(mesh::parse_pose(machine, point.pose_text, "channel " + channel.channel.id));
    }
  }
  for (PointTest& test : tests) set_sums(test, observations);
  return tests;
}

VectorXd gains_of(const PointTest& test) { return test.weights_of_sums().rowwise().norm(); }

namespace {

/// The motion of the tool against the table at the points of a test, at the times of its channels.
struct TestMotion {
  std::vector<MatrixXd> moved;  ///< (x, y, z) (n x points) um from the start
  MatrixXd rms;                 ///< (3 x points)
};

TestMotion motion_of(const mesh::Machine& machine, const Observations& observations, const PointTest& test,
                     const Response& response) {
  const Observations& record = observations.each()[test.record];
  const std::string& id = observations.channels[test.channels.front()].channel.id;
  const auto channel = std::find_if(record.channels.begin(), record.channels.end(),
                                    [&](const ObservedChannel& c) { return c.channel.id == id; });
  MatrixXd all = channel->means(response.deviations(machine, test.record, test.poses));
  if (channel->channel.zero != compensation::Zero::first) all.rowwise() -= Eigen::RowVectorXd(all.row(0));
  const Index points = std::ssize(test.poses);
  TestMotion motion;
  motion.rms.resize(3, points);
  for (Index a = 0; a < 3; ++a) {
    motion.moved.emplace_back(all(Eigen::all, Eigen::seqN(a, points, 3)));
    motion.rms.row(a) = motion.moved.back().colwise().norm() / std::sqrt(all.rows());
  }
  return motion;
}

}  // namespace

TestErrors errors_of(const mesh::Machine& machine, const Observations& observations, const PointTest& test,
                     const Response& response, const MeshAllowance& allowance) {
  const TestMotion motion = motion_of(machine, observations, test, response);
  const Eigen::Vector3d shares(allowance.of_displacement("dx"), allowance.of_displacement("dy"),
                               allowance.of_displacement("dz"));
  const bool whole = allowance.is_of_whole_motion();
  const Index points = std::ssize(test.poses);
  TestErrors errors;
  for (Index a = 0; a < 3; ++a) {
    const MatrixXd weights = test.weights(Eigen::all, Eigen::seqN(a, points, 3));
    for (Index b = 0; b < 3; ++b)
      if (a == b || whole) errors.joint.emplace_back(shares[a] * motion.moved[b] * weights.transpose());
  }
  const MatrixXd weights = test.weights_of_sums();
  VectorXd squares = VectorXd::Zero(weights.rows());
  for (Index i = 0; i < points; ++i) {
    for (Index a = 0; a < 3; ++a)
      squares +=
          (shares[a] * (whole ? motion.rms.col(i).norm() : motion.rms(a, i)) * weights.col(3 * i + a)).cwiseAbs2();
  }
  errors.independent = squares.cwiseSqrt();
  return errors;
}

MatrixXd with_sums(const std::vector<PointTest>& tests, const Observations& observations, const MatrixXd& stacked) {
  MatrixXd result = stacked;
  std::vector<Index> first(observations.channels.size() + 1, 0);
  for (std::size_t k = 0; k < observations.channels.size(); ++k)
    first[k + 1] = first[k] + observations.channels[k].size();
  for (const PointTest& test : tests) {
    const Index m = std::ssize(test.channels);
    if (m < 2) continue;
    for (Index k = 0; k < m; ++k) {
      const std::size_t of = test.channels[k];
      auto rows = result.middleRows(first[of], observations.channels[of].size());
      rows.setZero();
      for (Index l = 0; l < m; ++l) rows += test.sums(k, l) * stacked.middleRows(first[test.channels[l]], rows.rows());
    }
  }
  return result;
}

}  // namespace thermotwin::diagnosis
