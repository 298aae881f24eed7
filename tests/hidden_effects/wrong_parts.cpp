// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrong_parts.h"

#include <cmath>

#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/kinds.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/full_model.h"
#include "solver/thermal/assembly.h"

namespace thermotwin::hidden {

using diagnosis::Kind;

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double spot_m = 0.03;

/// The same in sum, but more here than there.
solver::SparseMatrix made_uneven(const solver::SparseMatrix& matrix, const VectorXd& uneven) {
  const VectorXd ones = VectorXd::Ones(matrix.rows());
  solver::SparseMatrix other = uneven.cwiseSqrt().asDiagonal() * matrix * uneven.cwiseSqrt().asDiagonal();
  const double before = ones.dot(matrix * ones), after = ones.dot(other * ones);
  if (after != 0.0) other *= before / after;
  return other;
}

}  // namespace

WrongParts wrong_parts(const solver::FullModel& full, const std::vector<Truth>& truths,
                       const std::vector<mesh::Pose>& poses, const std::vector<solver::OutputRows>& right,
                       const VectorXd& uneven) {
  WrongParts wrong;
  for (const Truth& truth : truths) {
    const Kind kind = truth.parameter.kind;
    if (!diagnosis::needs_parts(kind)) continue;
    mesh::MachineMesh mesh = full.mesh;
    mesh.machine = diagnosis::with_parameter(full.mesh.machine, truth.parameter, truth.value);
    const solver::ThermalSystem thermal = solver::assemble_thermal(mesh);
    if (kind == Kind::heat_capacity) {
      const solver::SparseMatrix change = made_uneven(thermal.capacity - full.thermal.capacity, uneven);
      wrong.capacity = wrong.capacity.size() > 0 ? solver::SparseMatrix(wrong.capacity + change) : change;
      continue;
    }
    const solver::ElasticModel elastic(mesh, thermal);
    const VectorXd share = kind == Kind::contact_stiffness ? VectorXd::Ones(uneven.size()).eval() : uneven;
    for (std::size_t p = 0; p < poses.size(); ++p) {
      solver::OutputRows change = elastic.output_rows(poses[p]);
      const auto differ = [&](Eigen::MatrixXd& rows, const Eigen::MatrixXd& before) {
        rows = ((rows - before) * share.asDiagonal()).eval();
      };
      differ(change.tool, right[p].tool);
      differ(change.table_axis, right[p].table_axis);
      differ(change.table_own, right[p].table_own);
      if (wrong.rows.size() <= p) {
        wrong.rows.push_back(std::move(change));
        continue;
      }
      wrong.rows[p].tool += change.tool;
      wrong.rows[p].table_axis += change.table_axis;
      wrong.rows[p].table_own += change.table_own;
    }
  }
  return wrong;
}

std::pair<std::string, Vector3d> drawn_place(const mesh::MachineMesh& mesh, Random& random) {
  double total = 0.0;
  for (const mesh::TetMesh& body : mesh.bodies)
    for (Index f = 0; f < body.face_count(); ++f) total += body.face_area(f);
  double left = total * random.uniform();
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    for (Index f = 0; f < mesh.bodies[b].face_count(); ++f) {
      if ((left -= mesh.bodies[b].face_area(f)) <= 0.0)
        return {mesh.machine.bodies[b].id, mesh.bodies[b].face_centre(f)};
    }
  }
  return {mesh.machine.bodies.back().id, mesh.bodies.back().face_centre(0)};
}

VectorXd warm_spot(const solver::FullModel& full, const std::string& body, const Vector3d& centre) {
  const std::size_t b = full.mesh.machine.body_index(body);
  const mesh::TetMesh& mesh = full.mesh.bodies[b];
  VectorXd heat = VectorXd::Zero(full.thermal.size);
  for (Index f = 0; f < mesh.face_count(); ++f) {
    const double distance = (mesh.face_centre(f) - centre).norm() / spot_m;
    for (Index k = 0; k < 3; ++k)
      heat[full.mesh.first_node[b] + mesh.faces(k, f)] += mesh.face_area(f) * std::exp(-0.5 * distance * distance);
  }
  return heat / heat.sum();
}

}  // namespace thermotwin::hidden
