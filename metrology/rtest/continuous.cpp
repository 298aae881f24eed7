// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/continuous.h"

#include <algorithm>

#include "core/error.h"

namespace thermotwin::metrology {

using Eigen::Vector3d;

bool is_continuous(const RTestRecord& record) {
  return record.moved_axes().size() == 1 &&
         std::all_of(record.cycles.begin(), record.cycles.end(),
                     [](const RTestCycle& cycle) { return cycle.points.size() >= least_arc_points; });
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
  const Eigen::Isometry3d carrier =
      mesh::KinematicChain::frame(branch, static_cast<int>(at - branch.begin()) - 1, first.positions);
  const Vector3d origin = carrier * axis.origin;
  const ArcFrame frame = ArcFrame::about(carrier.linear() * axis.direction, first.nominal - origin, origin);
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
