// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/bound/model.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/progress.h"
#include "core/range.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/basis.h"
#include "reduction/basis/responses.h"
#include "reduction/model/trained_range.h"
#include "solver/campaign/full_model.h"
#include "solver/elastic/tcp.h"
#include "solver/linear/sparse_factor.h"
#include "solver/thermal/direct.h"
#include "solver/thermal/integrator.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// From what stays after ten months to a few steps.
constexpr double time_constants_s[] = {2.5e7, 8.64e5, 1.6e5, 3e4, 6e3, 1.2e3, 240.0};
/// An output's row is rough: the adjoint's first stages are (E + g h K)^-1 c and E (E + g h K)^-1 once more each.
constexpr int first_stages = 4;
constexpr double short_time_s = 30.0;
constexpr double least_dual_direction = 1e-8;

/// Fields of 1 K in one body, one fluid node, and in parts that nothing holds.
MatrixXd stored_heat(const solver::FullModel& full, const MatrixXd& loose_fields) {
  const Index bodies = std::ssize(full.mesh.machine.bodies), fluids = full.thermal.size - full.thermal.nodes;
  MatrixXd fields = MatrixXd::Zero(full.thermal.size, bodies + fluids + loose_fields.cols());
  for (Index b = 0; b < bodies; ++b) {
    const auto first = full.mesh.first_node[b], last = full.mesh.first_node[b + 1];
    fields.col(b).segment(first, last - first).setOnes();
  }
  fields.block(full.thermal.nodes, bodies, fluids, fluids).setIdentity();
  fields.rightCols(loose_fields.cols()) = loose_fields;
  return fields;
}

/// (A(p) + E/T)^-T c at the operating points, with the stages after it where T is that of a step. A response at T
/// has the energy of T^-1/2 times it.
MatrixXd output_responses(const solver::ThermalSystem& thermal, const std::vector<OperatingPoint>& points,
                          const MatrixXd& outputs, const std::vector<double>& steps_s) {
  struct Shift {
    double time;
    int stages;
  };
  std::vector<Shift> shifts;
  for (const double time : time_constants_s) shifts.push_back({time, 1});
  for (const double step : steps_s) shifts.push_back({solver::sdirk_gamma * step, first_stages});
  Index blocks = 0;
  for (const Shift& shift : shifts) blocks += shift.stages;
  const Index count = outputs.cols();
  MatrixXd all(thermal.size, count * blocks * std::ssize(points));
  core::Progress progress("output responses for the bound", points.size() * shifts.size());
  solver::ThermalDirectSolver solver(thermal);
  VectorXd length = VectorXd::Zero(count);  // of each output's first response, so that metres and radians compare
  Index at = 0;
  for (const OperatingPoint& point : points) {
    for (const Shift& shift : shifts) {
      solver.factorise(point.c.p, 1.0 / shift.time);
      for (int stage = 0; stage < shift.stages; ++stage, at += count) {
        if (stage > 0) {
          all.middleCols(at, count) =
              solver.solve(thermal.capacity * all.middleCols(at - count, count), true) / shift.time;
          continue;
        }
        MatrixXd response = solver.solve(outputs, true) / std::sqrt(shift.time);
        for (Index i = 0; i < count; ++i) {
          if (length(i) == 0.0) length(i) = std::sqrt(std::abs(outputs.col(i).dot(response.col(i))));
          if (length(i) > 0.0) response.col(i) /= length(i);
        }
        all.middleCols(at, count) = response;
      }
      progress.advance();
    }
  }
  return all;
}

/// Leading directions of the columns, compared by the residual that one left out leaves in a short step,
/// |(M + E/T) x| in the dual norm of M: that is what the bound sees of it.
MatrixXd leading(const solver::SparseMatrix& m, const solver::SparseMatrix& capacity, const MatrixXd& columns,
                 Index most) {
  const MatrixXd residual = m * columns + (capacity * columns) / short_time_s;
  const MatrixXd gram = residual.transpose() * solver::SparseFactor(m).solve(residual);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(0.5 * (gram + gram.transpose())));
  const Index count = gram.rows();
  Index kept = 0;
  while (kept < std::min(count, most) && eigen.eigenvalues()(count - 1 - kept) > least_dual_direction *
                                                                                     least_dual_direction *
                                                                                     eigen.eigenvalues()(count - 1))
    ++kept;
  return columns * eigen.eigenvectors().rightCols(kept).rowwise().reverse();
}

}  // namespace

MatrixXd error_rows(const solver::FullModel& full, const mesh::Pose& pose) {
  const solver::OutputRows rows = full.elastic.output_rows(pose);
  MatrixXd columns(full.thermal.size, 6);
  for (Index j = 0; j < full.thermal.size; ++j) {
    columns.row(j) =
        solver::tcp_error(full.mesh.machine, pose, rows.tool.col(j), rows.table_axis.col(j), rows.table_own.col(j))
            .error;
  }
  return columns;
}

void require_affine(const mesh::Machine& machine) {
  const auto refuse = [&](const char* table, const std::string& id, const char* value, const char* allowed) {
    throw core::InputError(fmt::format("{}: [[{}]] id = \"{}\"", machine.path.string(), table, id), value,
                           fmt::format("{}: a bound needs an equation that is affine in its coefficients", allowed));
  };
  for (const mesh::FilmSpec& film : machine.films) {
    if (film.emissivity.value > 0.0 && film.exact_radiation)
      refuse("film", film.id, "radiation = \"exact\"", "radiation = \"linear\"");
  }
  for (const mesh::BodySpec& body : machine.bodies) {
    const mesh::Material& material = machine.material(body.material);
    if (!material.conductivity_table.at.empty())
      refuse("material", material.id, "conductivity_table", "conductivity_W_mK");
    if (!material.specific_heat_table.at.empty())
      refuse("material", material.id, "specific_heat_table", "specific_heat_J_kgK");
  }
}

void BoundOptions::validate() const {
  core::require_option(dual >= 0, "bound dual", dual, "0 or more columns");
  core::require_option(most_dual >= 1, "bound most_dual", most_dual, "1 or more columns");
  for (const double step : steps_s)
    core::require_option(step > 0.0 && std::isfinite(step), "bound steps_s", step, "lengths above 0");
  probes.validate();
}

BoundModel make_bound_model(const solver::FullModel& full, const MatrixXd& basis, const TrainedRange& range,
                            const std::vector<mesh::Pose>& poses, const BoundOptions& options, MatrixXd* space) {
  options.validate();
  const solver::ThermalSystem& thermal = full.thermal;
  require_affine(full.mesh.machine);
  const auto terms = std::ssize(thermal.terms);
  if (range.low.size() != terms || basis.rows() != thermal.size || poses.empty()) {
    throw core::SolverError(fmt::format("bound: {} coefficients of {}, a basis of {} rows, {} poses", range.low.size(),
                                        terms, basis.rows(), poses.size()));
  }

  BoundModel model;
  model.machine_hash = full.mesh.machine.hash;
  model.full_size = thermal.size;
  model.failure = options.probes.count > 0 ? options.probes.failure : 0.0;
  model.least = range.low.cwiseMax(0.0);
  model.poses = poses;

  MatrixXd outputs(thermal.size, 6 * std::ssize(poses));
  for (Index i = 0; i < std::ssize(poses); ++i) outputs.middleCols(6 * i, 6) = error_rows(full, poses[i]);
  const solver::OperatingModel operating(full.mesh.machine, thermal.layout);
  const std::vector<OperatingPoint> points = operating_points(operating);
  MatrixXd loose_fields;
  const solver::SparseMatrix least = least_conduction(thermal, model.least, loose_fields);
  const MatrixXd heat = stored_heat(full, loose_fields);
  const MatrixXd responses =
      leading(least, thermal.capacity, output_responses(thermal, points, outputs, options.steps_s),
              std::min(options.most_dual, options.dual * std::ssize(poses)));
  MatrixXd directions(thermal.size, 1 + heat.cols() + responses.cols());
  directions << VectorXd::Ones(thermal.size), heat, responses;
  const MatrixXd w = orthonormal(thermal.capacity, directions);
  directions.resize(thermal.size, w.cols() + basis.cols());
  directions << w, basis;
  const MatrixXd u = orthonormal(thermal.capacity, directions);
  if (space) *space = u;

  const RowMajorMatrix probes = residual_probes(least, options.probes);
  model.layout = thermal.layout;
  const MatrixXd stored = project(thermal.capacity, probes, RowMajorMatrix(u));
  model.terms = bound_terms(thermal, u, w.cols(), probes, stored);
  model.inputs = (thermal.inputs.transpose() * u).transpose();
  model.one_kelvin = u.transpose() * (thermal.capacity * VectorXd::Ones(thermal.size));
  model.primal_inputs = stored * model.inputs - (thermal.inputs.transpose() * probes).transpose();
  for (Index i = 0; i < std::ssize(poses); ++i) {
    const MatrixXd c = outputs.middleCols(6 * i, 6);
    model.rows.push_back(c.transpose() * u);
    model.rest.push_back(probes.transpose() * c -
                         stored.leftCols(w.cols()) * model.rows.back().leftCols(w.cols()).transpose());
  }
  return model;
}

}  // namespace thermotwin::reduction
