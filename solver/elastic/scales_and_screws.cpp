// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/scales_and_screws.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::solver {
namespace {

using Eigen::Vector3d;

constexpr int intervals = 40;  // temperature along a tape or screw is linear between its stations

std::vector<int> whole_skin(const mesh::TetMesh& body) {
  std::vector<int> faces(body.face_count());
  std::iota(faces.begin(), faces.end(), 0);
  return faces;
}

/// Four points of the skin about a place of a line, in a bore or on a screw: transverse gradients and
/// rotations about the line cancel.
std::vector<SkinPoint> around(const mesh::TetMesh& body, const mesh::TriangleTree& skin, const Vector3d& place,
                              const Vector3d& direction) {
  const double radius = skin_point(body, skin, place).distance;
  const Vector3d one = direction.unitOrthogonal(), other = direction.cross(one);
  std::vector<SkinPoint> points;
  for (const Vector3d& across : {one, other, Vector3d(-one), Vector3d(-other)})
    points.push_back(skin_point(body, skin, place + radius * across));
  return points;
}

Vector3d mean_place(const mesh::TetMesh& body, const std::vector<SkinPoint>& points) {
  Vector3d sum = Vector3d::Zero();
  for (const SkinPoint& point : points)
    for (Eigen::Index i = 0; i < point.node.size(); ++i) sum += point.weight[i] * body.points.col(point.node[i]);
  return sum / std::ssize(points);
}

Functional mean_motion(const std::vector<SkinPoint>& points, const Vector3d& direction) {
  Functional sum;
  for (const SkinPoint& point : points)
    for (auto [dof, weight] : point_motion(point, direction)) sum.emplace_back(dof, weight / std::ssize(points));
  tidy(sum);
  return sum;
}

void require_elastic(const mesh::Machine& machine, const std::string& place, std::initializer_list<int> bodies) {
  for (int body : bodies) {
    if (!machine.bodies[body].elastic) {
      throw core::InputError(place, "body '" + machine.bodies[body].id + "' with elastic = false",
                             "elastic bodies on both sides");
    }
  }
}

}  // namespace

AxisFeedback AxisFeedback::of_scale(const mesh::MachineMesh& mesh, int index, UnitFunctionals& units) {
  const mesh::Machine& machine = mesh.machine;
  const mesh::ScaleSpec& spec = machine.scales[index];
  const std::string place = machine.path.filename().string() + " scale of axis " + spec.axis;
  AxisFeedback scale;
  scale.scale = index;
  scale.carrier = scale.body = machine.body_index(spec.carrier);
  scale.head = machine.body_index(spec.head_body);
  require_elastic(machine, place, {scale.carrier, scale.head});
  scale.direction = machine.axes[machine.axis_index(spec.axis)].direction;
  const Vector3d tape = spec.end - spec.start;
  const double length = std::abs(tape.dot(scale.direction));
  if (length < 0.99 * tape.norm() || length <= 0.0)
    throw core::InputError(place, "tape from start_mm to end_mm is not along the axis", "ends along the axis");
  scale.start = tape.dot(scale.direction) > 0.0 ? spec.start : spec.end;
  scale.fixed = spec.fixed_at;
  scale.head_point = spec.head;
  scale.expansion = spec.expansion.value;
  const mesh::TetMesh& carrier = mesh.bodies[scale.carrier];
  const mesh::TetMesh& head = mesh.bodies[scale.head];
  const mesh::TriangleTree carrier_skin(carrier.points, carrier.faces), head_skin(head.points, head.faces);
  scale.head_end = {scale.head,
                    units.add(scale.head, point_motion(skin_point(head, head_skin, spec.head), scale.direction))};
  scale.fixed_end = {
      scale.carrier,
      units.add(scale.carrier, point_motion(skin_point(carrier, carrier_skin, spec.fixed_at), scale.direction))};
  auto rigid = rigid_motion(head, whole_skin(head), Vector3d::Zero(), "skin of " + spec.head_body);
  for (std::size_t i = 0; i < 3; ++i) scale.head_end.rotation[i] = units.add(scale.head, std::move(rigid[3 + i]));
  scale.head_end.bracket = (scale.fixed - scale.head_point).cross(scale.direction);  // blind along the tape
  for (int i = 0; i <= intervals; ++i) {
    const double at = length * i / intervals;
    scale.stations.push_back({at, {skin_point(carrier, carrier_skin, scale.start + at * scale.direction)}});
  }
  return scale;
}

std::optional<AxisFeedback> AxisFeedback::of_screw(const mesh::MachineMesh& mesh, int index, UnitFunctionals& units) {
  const mesh::Machine& machine = mesh.machine;
  const mesh::ScrewSpec& spec = machine.screws[index];
  const mesh::Axis& axis = machine.axes[machine.axis_index(spec.axis)];
  AxisFeedback scale;
  scale.constrains = axis.feedback == "screw";
  if (!scale.constrains && !spec.far_bearing) return std::nullopt;
  const std::string place = machine.path.filename().string() + " screw of axis " + spec.axis;
  scale.screw = index;
  scale.body = machine.body_index(spec.body);
  scale.carrier = machine.body_index(spec.carrier);
  scale.head = machine.body_index(spec.nut_body);
  require_elastic(machine, place, {scale.carrier, scale.head});
  scale.direction = axis.direction;
  scale.fixed = spec.bearing;
  scale.head_point = spec.nut;
  scale.expansion = spec.expansion.value;

  const auto end_of = [&](int body_index, const Vector3d& at) {
    const mesh::TetMesh& body = mesh.bodies[body_index];
    const mesh::TriangleTree skin(body.points, body.faces);
    const std::vector<SkinPoint> points = around(body, skin, at, scale.direction);
    End end{body_index, units.add(body_index, mean_motion(points, scale.direction))};
    auto rigid =
        rigid_motion(body, whole_skin(body), Vector3d::Zero(), "skin of a body at the screw of axis " + spec.axis);
    for (std::size_t i = 0; i < 3; ++i) end.rotation[i] = units.add(body_index, std::move(rigid[3 + i]));
    end.bracket = (scale.fixed - mean_place(body, points)).cross(scale.direction);
    return end;
  };
  scale.fixed_end = end_of(scale.carrier, spec.bearing);
  if (scale.constrains) scale.head_end = end_of(scale.head, spec.nut);

  const mesh::TetMesh& screw = mesh.bodies[scale.body];
  const Eigen::RowVectorXd along = scale.direction.transpose() * (screw.points.colwise() - spec.bearing);
  const double low = along.minCoeff(), length = along.maxCoeff() - low;
  scale.start = spec.bearing + low * scale.direction;
  const mesh::TriangleTree skin(screw.points, screw.faces);
  for (int i = 0; i <= intervals; ++i) {
    const double at = length * i / intervals;
    scale.stations.push_back({at, around(screw, skin, scale.start + at * scale.direction, scale.direction)});
  }
  if (spec.far_bearing) {
    double volume = 0.0;
    for (Eigen::Index e = 0; e < screw.elements(); ++e) volume += screw.volume(e);
    const double young = machine.material(machine.bodies[scale.body].material).young;
    scale.far_end = end_of(scale.carrier, *spec.far_bearing);
    scale.far = (*spec.far_bearing - spec.bearing).dot(scale.direction);
    scale.compliance = length / (young * volume);
    scale.bearing_compliance = spec.bearing_stiffness > 0.0 ? 1.0 / spec.bearing_stiffness : 0.0;
  }
  return scale;
}

void AxisFeedback::append(const mesh::Machine& machine, const mesh::Pose& pose, std::vector<Spring>& springs) const {
  const double from = (fixed - start).dot(direction);
  const auto add_end = [](Spring& spring, const End& end, double weight) {
    spring.gap.push_back({end.body, end.unit, weight});
    for (std::size_t i = 0; i < 3; ++i)
      if (end.rotation[i] >= 0) spring.gap.push_back({end.body, end.rotation[i], weight * end.bracket[i]});
  };
  /// Adds factor times the expansion from the fixed point to a place of the line.
  const auto add_expansion = [&](Spring& spring, double to, double factor) {
    spring.expansion_body = body;
    spring.expands_scale = scale;
    spring.expands_screw = screw;
    const double low = std::min(from, to), high = std::max(from, to), sign = to >= from ? factor : -factor;
    const auto add = [&](const Station& station, double weight) {
      for (const SkinPoint& point : station.points) {
        for (Eigen::Index i = 0; i < point.node.size(); ++i) {
          spring.expansion.emplace_back(point.node[i],
                                        sign * expansion * weight * point.weight[i] / std::ssize(station.points));
        }
      }
    };
    // Beyond the ends, the end's temperature counts.
    const double first = stations.front().at, last = stations.back().at;
    const double before = std::max(0.0, std::min(high, first) - low);
    const double after = std::max(0.0, high - std::max(low, last));
    if (before > 0.0) add(stations.front(), before);
    if (after > 0.0) add(stations.back(), after);
    for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
      const Station &left = stations[i], &right = stations[i + 1];
      const double a = std::max(low, left.at), b = std::min(high, right.at);
      if (b <= a) continue;
      const double share = (0.5 * (a + b) - left.at) / (right.at - left.at);  // mean of a linear T
      add(left, (b - a) * (1.0 - share));
      add(right, (b - a) * share);
    }
  };

  const double whole = 2.0 * bearing_compliance + compliance * std::abs(far);
  if (constrains) {
    const Vector3d head_now = mesh::body_transform(machine, carrier, pose).inverse() *
                              (mesh::body_transform(machine, head, pose) * head_point);
    const double to = (head_now - start).dot(direction);
    double share = 0.0;  // of the pull's compliance, from the fixed bearing to the nut
    if (whole > 0.0) {
      const double between = std::clamp((to - from) / far, 0.0, 1.0) * std::abs(far);
      share = (bearing_compliance + compliance * between) / whole;
    }
    Spring spring;
    add_end(spring, head_end, 1.0);
    add_end(spring, fixed_end, share - 1.0);
    add_expansion(spring, to, 1.0);
    if (share > 0.0) {
      add_end(spring, far_end, -share);
      add_expansion(spring, from + far, -share);
    }
    springs.push_back(std::move(spring));
  }
  if (whole > 0.0) {
    const double sign = far > 0.0 ? 1.0 : -1.0;  // tension is positive
    Spring pull;
    pull.screw = screw;
    pull.flexibility = whole;
    add_end(pull, far_end, sign);
    add_end(pull, fixed_end, -sign);
    add_expansion(pull, from + far, sign);
    springs.push_back(std::move(pull));
  }
}

}  // namespace thermotwin::solver
