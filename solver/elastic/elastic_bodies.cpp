// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/elastic_bodies.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "core/error.h"
#include "core/thread_pool.h"
#include "solver/linear/available_memory.h"

namespace thermotwin::solver {

namespace {

constexpr Eigen::Index most_columns = 96, least_columns = 8;  // dense right-hand sides held in memory per body
constexpr double column_bytes = 2.5e8;                        // that these should take at most

Eigen::Index columns_at_once(Eigen::Index nodes) {
  const auto fit = static_cast<Eigen::Index>(column_bytes / (2.0 * 3.0 * 8.0 * nodes));
  return std::clamp(fit / least_columns * least_columns, least_columns, most_columns);
}

/// Without the parts that move the body rigidly: orthogonal to them.
void balance(const Eigen::MatrixXd& rigid, Eigen::MatrixXd& columns) {
  const Eigen::MatrixXd gram = rigid.transpose() * rigid;
  columns -= rigid * gram.ldlt().solve(rigid.transpose() * columns);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

ElasticBodies::ElasticBodies(const mesh::MachineMesh& mesh)
    : machine(mesh.machine),
      first_node(mesh.first_node),
      units(mesh.bodies.size()),
      bodies(mesh.bodies.size()),
      factors(mesh.bodies.size()),
      responses(mesh.bodies.size()),
      thermal(mesh.bodies.size()) {
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b)
    if (mesh.machine.bodies[b].elastic) elastic.push_back(b);
}

MemoryNeed ElasticBodies::memory_need(const std::vector<SparseAnalysis>& analyses) const {
  MemoryNeed need;
  std::vector<double> works, blocks;
  for (std::size_t i = 0; i < elastic.size(); ++i) {
    const std::size_t b = elastic[i];
    const double n = nodes(elastic[i]);
    const double matrix = 12.0 * bodies[b].stiffness.nonZeros();
    need.other += matrix + 8.0 * n * std::ssize(units.of(elastic[i]));
    if (!analyses.empty()) {
      need.factors += analyses[i].factor_bytes;
      works.push_back(analyses[i].work_bytes);
    }
    need.iterative += 2.0 * matrix;  // levels, their transfers and working blocks
    blocks.push_back(3.0 * 3.0 * 8.0 * n * columns_at_once(nodes(elastic[i])));
  }
  // Bodies that are worked on at the same time.
  for (auto* sizes : {&works, &blocks}) {
    std::sort(sizes->rbegin(), sizes->rend());
    sizes->resize(std::min<std::size_t>(sizes->size(), core::thread_count()));
  }
  for (double work : works) need.work += work;
  for (double block : blocks) need.other += block;
  return need;
}

void ElasticBodies::factorise(const mesh::MachineMesh& mesh, const ElasticOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  SpdOptions solver;
  solver.factor.block = solver.multigrid.block = 3;
  solver.multigrid.tolerance = options.tolerance;
  std::vector<SparseAnalysis> analyses;
  if (options.choice != SolverChoice::iterative) analyses.resize(elastic.size());
  core::parallel_for(0, elastic.size(), [&](std::size_t i) {
    const std::size_t b = elastic[i];
    const mesh::BodySpec& spec = machine.bodies[b];
    bodies[b] = assemble_elastic(mesh.bodies[b], machine.material(spec.material), spec.id);
    if (!analyses.empty()) analyses[i] = analyse(bodies[b].stiffness, solver.factor);
  });
  if (options.plan) {
    options.plan->elastic = memory_need(analyses);
    for (const SparseAnalysis& analysis : analyses) options.plan->wide = options.plan->wide || analysis.wide;
    // The matrices counted as needed are there already.
    double there = 0.0;
    for (int body : elastic) there += 12.0 * (bodies[body].stiffness.nonZeros());
    decide(*options.plan, options.choice, available_memory() + there);
    solver.kind = options.plan->elastic_solver;
  } else if (options.choice == SolverChoice::iterative) {
    solver.kind = LinearSolver::iterative;
  }
  summary.solver = solver.kind;
  core::parallel_for(0, elastic.size(), [&](std::size_t i) {
    const std::size_t b = elastic[i];
    SpdOptions of_body = solver;
    if (solver.kind == LinearSolver::iterative) of_body.multigrid.near_null = bodies[b].rigid;
    try {
      factors[b] = std::make_unique<SpdSolver>(bodies[b].stiffness, of_body, analyses.empty() ? nullptr : &analyses[i]);
    } catch (const core::SolverError& error) {
      throw core::SolverError("body '" + machine.bodies[b].id + "': " + error.what());
    }
    bodies[b].stiffness = SparseMatrix();  // only its factor is needed from here on
  });
  for (int body : elastic) summary.factor_bytes += factors[body]->memory_bytes();
  summary.factor_seconds = seconds_since(start);
}

/// By a factor, K^+ has the three points that hold the body; balanced loads (all that the machine
/// ever puts on a body) do not feel them. Iterative solves balance first: the tolerance then is
/// relative to what strains the body, and the rigid rest is taken out again.
Eigen::MatrixXd ElasticBodies::apply_inverse(int body, Eigen::MatrixXd loads) const {
  const std::size_t b = body;
  const bool iterative = !factors[b]->is_direct();
  if (iterative) balance(bodies[b].rigid, loads);
  clear_fixed(bodies[b], loads);
  Eigen::MatrixXd motion = factors[b]->solve(loads);
  if (iterative) balance(bodies[b].rigid, motion);
  return motion;
}

void ElasticBodies::solve_units(int body) {
  const std::size_t b = body;
  const std::vector<Functional>& functionals = units.of(body);
  const auto count = std::ssize(functionals);
  BodyResponse& response = responses[b];
  response.gram.setZero(count, count);
  response.rigid.setZero(6, count);
  response.centre = bodies[b].centre;
  response.length = bodies[b].length;
  thermal[b].resize(nodes(body), count);
  for (Eigen::Index u = 0; u < count; ++u) {
    for (const auto& [dof, weight] : functionals[u])
      response.rigid.col(u) += weight * bodies[b].rigid.row(dof).transpose();
  }
  const Eigen::Index at_once = columns_at_once(nodes(body));
  for (Eigen::Index first = 0; first < count; first += at_once) {
    const Eigen::Index width = std::min(at_once, count - first);
    Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * nodes(body), width);
    for (Eigen::Index u = 0; u < width; ++u)
      for (const auto& [dof, weight] : functionals[first + u]) loads(dof, u) += weight;
    const Eigen::MatrixXd motion = apply_inverse(body, std::move(loads));
    thermal[b].middleCols(first, width).noalias() = bodies[b].thermal_load.transpose() * motion;
    for (Eigen::Index u = 0; u < count; ++u)
      for (Eigen::Index v = 0; v < width; ++v) response.gram(u, first + v) = evaluate(functionals[u], motion.col(v));
  }
  response.gram = (0.5 * (response.gram + response.gram.transpose())).eval();
}

void ElasticBodies::solve_units() {
  const auto start = std::chrono::steady_clock::now();
  core::parallel_for(0, elastic.size(), [&](std::size_t i) { solve_units(elastic[i]); });
  for (int body : elastic) summary.unit_solves += std::ssize(units.of(body));
  summary.unit_seconds = seconds_since(start);
}

}  // namespace thermotwin::solver
