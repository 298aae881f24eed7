// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/continuous.h"

#include <algorithm>

#include "core/error.h"
#include "metrology/rtest/slips.h"

namespace thermotwin::metrology {

using Eigen::Vector3d;

namespace {

/// Not so where the axis carries the tool, or the sphere is on the axis.
bool points_move(const RTestCycle& cycle) {
  return std::any_of(cycle.points.begin(), cycle.points.end(), [&](const RTestPoint& point) {
    return (point.nominal - cycle.points.front().nominal).norm() > places_apart;
  });
}

}  // namespace

bool is_continuous(const RTestRecord& record) {
  return record.moved_axes().size() == 1 && points_move(record.cycles.front()) &&
         std::all_of(record.cycles.begin(), record.cycles.end(),
                     [](const RTestCycle& cycle) { return cycle.points.size() >= least_arc_points; });
}

namespace {

/// Index of X, Y or Z along which an axis of rotation is.
Eigen::Index along(const mesh::ChainAxis& axis) {
  Eigen::Index most = 0;
  axis.direction.cwiseAbs().maxCoeff(&most);
  return most;
}

}  // namespace

ArcNames arc_names(const RTestRecord& record) {
  const mesh::ChainAxis& axis = *record.chain.find(record.moved_axes().front());
  ArcNames names;
  for (Eigen::Index i = 0; i < 2; ++i) {
    const Eigen::Index at = (along(axis) + 1 + i) % 3;
    names.centre[i] = std::string(1, "XYZ"[at]) + "0" + axis.id;
    names.tilt[i] = std::string(1, "ABC"[at]) + "0" + axis.id;
  }
  return names;
}

std::vector<ArcFit> fit_cycles(const RTestRecord& record, CircleMethod method) {
  if (!is_continuous(record)) {
    throw core::InputError(record.source, "no continuous test",
                           "cycles of at least 20 points that turn one rotary axis");
  }
  const std::string id = record.moved_axes().front();
  const mesh::ChainAxis& axis = *record.chain.find(id);
  const std::vector<mesh::ChainAxis>& branch = axis.table_side ? record.chain.table : record.chain.tool;
  const auto at = std::find_if(branch.begin(), branch.end(), [&](const mesh::ChainAxis& a) { return a.id == id; });
  const RTestPoint& first = record.cycles.front().points.front();
  const Eigen::Isometry3d carrier = mesh::KinematicChain::frame(branch, at - branch.begin() - 1, first.positions);
  const Eigen::Index letter = along(axis);
  const Vector3d direction = axis.direction[letter] < 0.0 ? Vector3d(-axis.direction) : axis.direction;
  const ArcFrame frame = ArcFrame::about(carrier.linear() * direction,
                                         carrier.linear() * Vector3d::Unit((letter + 1) % 3), carrier * axis.origin);
  const double sign = axis.table_side ? -1.0 : 1.0;  // deviation = tool - workpiece
  std::vector<ArcFit> fits;
  for (const RTestCycle& cycle : record.cycles) {
    Eigen::MatrixX3d points(std::ssize(cycle.points), 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      points.row(i) = (cycle.points[i].nominal + sign * cycle.points[i].deviation).transpose();
    fits.push_back(fit_arc(points, frame, method, cycle.place));
  }
  return fits;
}

}  // namespace thermotwin::metrology
