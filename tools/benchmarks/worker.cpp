// SPDX-License-Identifier: GPL-3.0-or-later
// What is measured of thermotwin itself: one piece of work a process, so that its peak memory is its
// own. Prints lines "name value"; times in seconds.

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <iterator>

#include "core/error.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/reduce.h"
#include "reduction/model/exact_stepper.h"
#include "reduction/model/model_file.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"
#include "solver/elastic/assembly.h"
#include "solver/linear/multigrid.h"
#include "solver/linear/sparse_factor.h"
#include "solver/operation/layout.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "tools/benchmarks/body_case.h"
#include "tools/benchmarks/control_rows.h"
#include "tools/benchmarks/report.h"
#include "tools/benchmarks/stopwatch.h"

using namespace thermotwin;
using bench::print;
using bench::Watch;

namespace {

struct Options {
  std::string case_path = "cases/vmc5", size = "coarse", body = "column", set = "ambient", load;
  std::filesystem::path folder, model, out;
  int steps = 100, threads = 1, decks = 6, columns = 1, order = 0;
  long rows = 100000;
  bool apart = false, wall = false;
};

struct Setup {
  solver::Case machine_case;
  double factor;
  explicit Setup(const Options& options)
      : machine_case(solver::read_case(options.case_path)),
        factor(mesh::size_factor(machine_case.machine, options.size)) {}
  mesh::MachineMesh mesh(const Options& options) const {
    return mesh::build_machine_mesh(machine_case.machine, {factor, options.folder / "cache"});
  }
};

/// Coefficients of each step of a load program, chillers at the reference temperature.
std::vector<solver::Coefficients> coefficients(const solver::OperatingModel& model, const solver::LoadProgram& load,
                                               const std::vector<double>& ends) {
  const Eigen::VectorXd inlet = Eigen::VectorXd::Zero(std::ssize(model.machine().coolants));
  std::vector<solver::Coefficients> all;
  double from = 0.0;
  for (const double end : ends) {
    all.push_back(model.coefficients(load.row(from, end), inlet));
    from = end;
  }
  return all;
}

std::vector<double> first_steps(const solver::LoadProgram& load, int steps) {
  std::vector<double> ends = load.step_ends();
  ends.resize(std::min<std::size_t>(ends.size(), steps));
  return ends;
}

void write_files(const Options& options) {
  const Setup setup(options);
  const bench::BodyCase one =
      bench::body_case(setup.machine_case.machine, options.body, setup.factor, options.folder / "cache");
  bench::write_plain(options.folder / "body.txt", one);
  bench::write_decks(options.folder, one, options.decks);
  print("nodes", one.mesh.nodes());
  print("elements", one.mesh.bodies[0].elements());
}

void heat(const Options& options) {
  const Setup setup(options);
  const bench::BodyCase one =
      bench::body_case(setup.machine_case.machine, options.body, setup.factor, options.folder / "cache");
  Watch time(options.threads, options.wall);
  const solver::ThermalSystem system = solver::assemble_thermal(one.mesh);
  print("assembly", time.seconds());
  const solver::OperatingModel model(one.mesh.machine, system.layout);
  // Further loads have the same films and other powers.
  std::vector<solver::Coefficients> c(options.columns,
                                      model.coefficients(model.channels().defaults(), Eigen::VectorXd(0)));
  for (std::size_t l = 1; l < c.size(); ++l) c[l].q *= 1.0 + 0.1 * l;
  solver::ThermalIntegrator integrator(system);
  Eigen::MatrixXd state = integrator.uniform(0.0).replicate(1, options.columns);
  time.restart();
  integrator.advance(state, c, one.step_s);
  print("first_step", time.seconds());
  std::vector<double> each;
  for (int i = 1; i < options.steps; ++i) {
    time.restart();
    integrator.advance(state, c, one.step_s);
    each.push_back(time.seconds());
  }
  print("step", bench::median(each));
  const solver::SparseFactor factor(system.conduction + system.capacity / one.step_s);
  print("factor_GB", 1e-9 * factor.memory_bytes());
  print("largest_K", state.col(0).maxCoeff());
  print("mean_K", state.col(0).mean());
}

/// How fast the machine reads memory: what bounds solves with a factor that no cache holds.
void memory(const Options& options) {
  constexpr std::size_t chunks = 64, each = 1 << 20;  // 512 MiB
  const std::vector<double> values(chunks * each, 1.0);
  std::vector<double> sums(chunks), seconds;
  for (int i = 0; i < 8; ++i) {
    const Watch time(options.threads, options.wall);
    core::parallel_for(0, chunks, [&](std::size_t chunk) {
      sums[chunk] = Eigen::Map<const Eigen::VectorXd>(values.data() + chunk * each, each).sum();
    });
    seconds.push_back(time.seconds());
  }
  print("GB_s", 8e-9 * (chunks * each) / bench::median(seconds));
  print("checksum", Eigen::Map<const Eigen::VectorXd>(sums.data(), chunks).sum());
}

void elastic(const Options& options) {
  const Setup setup(options);
  const bench::BodyCase one =
      bench::body_case(setup.machine_case.machine, options.body, setup.factor, options.folder / "cache");
  const mesh::TetMesh& mesh = one.mesh.bodies[0];
  Watch time(options.threads);
  const solver::ElasticBody body =
      solver::assemble_elastic(mesh, one.mesh.machine.material(one.mesh.machine.bodies[0].material), options.body);
  print("assembly", time.seconds());
  time.restart();
  solver::SparseFactorOptions factor_options;
  factor_options.block = 3;
  const solver::SparseFactor factor(body.stiffness, factor_options);
  print("factor", time.seconds());
  print("factor_nonzeros", factor.nonzeros());
  time.restart();
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * mesh.nodes(), 3 * bench::load_nodes);
  for (int i = 0; i < bench::load_nodes; ++i)
    for (int k = 0; k < 3; ++k) loads(3 * bench::load_node(mesh.nodes(), i) + k, 3 * i + k) = 1.0;
  solver::clear_fixed(body, loads);
  const Eigen::MatrixXd rows = body.thermal_load.transpose() * factor.solve(loads);
  print("rows", time.seconds());
  print("rows_norm", rows.norm());
}

/// As elastic, eight columns of it, by multigrid; loads as the elastic model has them: balanced.
void iterative(const Options& options) {
  const Setup setup(options);
  const bench::BodyCase one =
      bench::body_case(setup.machine_case.machine, options.body, setup.factor, options.folder / "cache");
  const mesh::TetMesh& mesh = one.mesh.bodies[0];
  solver::ElasticBody body =
      solver::assemble_elastic(mesh, one.mesh.machine.material(one.mesh.machine.bodies[0].material), options.body);
  constexpr Eigen::Index columns = 8;
  Watch time(options.threads);
  solver::MultigridOptions multigrid;
  multigrid.block = 3;
  multigrid.near_null = body.rigid;
  multigrid.tolerance = 1e-8;
  const solver::MultigridSolver solver(body.stiffness, multigrid);
  print("setup", time.seconds());
  time.restart();
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * mesh.nodes(), columns), motion(3 * mesh.nodes(), columns);
  for (int i = 0; i < columns; ++i) loads(3 * bench::load_node(mesh.nodes(), 2 * i + 1) + i % 3, i) = 1.0;
  loads -= body.rigid * (body.rigid.transpose() * body.rigid).llt().solve(body.rigid.transpose() * loads);
  solver::clear_fixed(body, loads);
  print("iterations", solver.solve(loads, motion));
  print("rows_norm", (body.thermal_load.transpose() * motion).norm());
  print("rows", time.seconds());
  print("columns", columns);
  print("multigrid_MiB", solver.memory_bytes() / 1048576.0);
  print("unknowns", loads.rows());
}

/// Nine programs of one time grid, as a block or each by itself.
void loads(const Options& options) {
  const Setup setup(options);
  const mesh::MachineMesh mesh = setup.mesh(options);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh);
  const solver::OperatingModel model(mesh.machine, system.layout);
  std::vector<std::string> names;
  if (options.set == "ambient") {
    for (int i = 1; i <= 9; ++i) names.push_back(fmt::format("ambient_{}", i));
  } else {
    names = {"spindle_3000", "spindle_6000", "spindle_12000", "x_rapid",   "y_rapid",
             "z_rapid",      "table_150",    "table_600",     "table_1200"};
  }
  std::vector<std::vector<solver::Coefficients>> c;
  std::vector<double> ends;
  for (const std::string& name : names) {
    const solver::LoadProgram load = setup.machine_case.load(name);
    const std::vector<double> own = first_steps(load, options.steps);
    if (!ends.empty() && own != ends)
      throw core::InputError(name, "other time steps than " + names[0], "loads of one time grid");
    ends = own;
    c.push_back(coefficients(model, load, ends));
  }
  Watch time(options.threads);
  const std::size_t width = options.apart ? 1 : names.size();
  double checksum = 0;
  for (std::size_t first = 0; first < names.size(); first += width) {
    solver::ThermalIntegrator integrator(system);
    Eigen::MatrixXd state = integrator.uniform(0.0).replicate(1, width);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      std::vector<solver::Coefficients> now;
      for (std::size_t l = first; l < first + width; ++l) now.push_back(c[l][i]);
      integrator.advance(state, now, ends[i] - (i == 0 ? 0.0 : ends[i - 1]));
    }
    checksum += state.sum();
  }
  print("load_step", time.seconds() / (names.size() * ends.size()));
  print("mean_K", checksum / (system.size * names.size()));
  print("unknowns", system.size);
}

/// Steps of a control: the state moves on and all outputs of the grid are read, with no film changing, with
/// three, with all; and the plain way, which sums and factorises in each step.
void online(const Options& options) {
  const reduction::ReducedModel stored = reduction::read_model(options.model);
  const reduction::ReducedModel model =
      options.order > 0 ? reduction::truncated(stored, std::min<Eigen::Index>(options.order, stored.system.order()))
                        : stored;
  const auto grid = mesh::workspace_poses(model.machine);
  const Eigen::MatrixXd values = reduction::value_rows(model, grid);
  const Eigen::Index each = values.rows() / std::ssize(grid);
  Eigen::MatrixXd rows(6 * std::ssize(grid), values.cols());
  for (Eigen::Index i = 0; i < std::ssize(grid); ++i) rows.middleRows(6 * i, 6) = values.middleRows(each * i, 6);
  const solver::OperatingModel operating(model.machine, model.system.layout);
  const solver::Coefficients nominal = operating.coefficients(
      operating.channels().defaults(), Eigen::VectorXd::Zero(std::ssize(model.machine.coolants)));
  std::vector<Eigen::Index> films;
  for (std::size_t j = 0; j < model.system.layout.terms.size(); ++j)
    if (model.system.layout.terms[j].kind == solver::TermKind::film) films.push_back(j);

  constexpr double step_s = 60.0;
  Eigen::VectorXd outputs(rows.rows());
  const auto measure = [&](const std::string& name, std::size_t changing, const auto& advance) {
    Eigen::VectorXd state = model.system.one_kelvin;
    solver::Coefficients c = nominal;
    std::vector<double> seconds;
    for (int i = 0; i < options.steps; ++i) {
      for (std::size_t f = 0; f < std::min(changing, films.size()); ++f)
        c.p(films[f]) = nominal.p(films[f]) * (1.0 + 0.3 * std::sin(0.1 * i + f));
      c.q(i % c.q.size()) += 1e-3;
      const auto begin = std::chrono::steady_clock::now();
      advance(state, c);
      outputs.noalias() = rows * state;
      seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    std::sort(seconds.begin(), seconds.end());
    print(name.c_str(), seconds[seconds.size() / 2]);
    print((name + "_999").c_str(), seconds[seconds.size() * 999 / 1000]);
  };
  reduction::ExactStepper exact(model.system);
  measure("fixed", 0, [&](Eigen::VectorXd& x, const solver::Coefficients& c) { exact.advance(x, c, step_s); });
  reduction::ReducedStepper three(model.system), all(model.system);
  measure("three", 3, [&](Eigen::VectorXd& x, const solver::Coefficients& c) { three.advance(x, c, step_s); });
  measure("all", films.size(), [&](Eigen::VectorXd& x, const solver::Coefficients& c) { all.advance(x, c, step_s); });
  Eigen::MatrixXd sum;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu(model.system.order());
  measure("plain", films.size(), [&](Eigen::VectorXd& x, const solver::Coefficients& c) {
    sum = model.system.conduction;
    for (Eigen::Index j = 0; j < c.p.size(); ++j)
      if (c.p(j) != 0.0) sum += c.p(j) * model.system.terms[j];
    sum = model.system.capacity + step_s * sum;
    lu.compute(sum);
    x = lu.solve(model.system.capacity * x + step_s * (model.system.inputs * c.q)).eval();
  });
  print("order", model.system.order());
  print("films", films.size());
  print("outputs", rows.rows());
}

void poses(const Options& options) {
  const Setup setup(options);
  const mesh::MachineMesh mesh = setup.mesh(options);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh);
  Watch time(options.threads);
  const solver::ElasticModel model(mesh, system);
  print("model", time.seconds());
  print("factor", model.summary().factor_seconds);
  print("unit_solves", model.summary().unit_solves);
  const std::vector<mesh::Pose> grid = mesh::workspace_poses(mesh.machine);
  std::vector<double> each;
  for (const mesh::Pose& pose : grid) {
    time.restart();
    if (!model.output_rows(pose).tool.allFinite()) throw core::SolverError("rows that are not finite");
    each.push_back(time.seconds());
  }
  print("pose", bench::median(each));
  time.restart();
  core::parallel_for(0, grid.size(), [&](std::size_t i) { model.output_rows(grid[i]); });
  print("all_poses", time.seconds());
  print("poses", grid.size());
  print("nodes", mesh.nodes());
}

/// The same steps of a load on the full and on the reduced model, in turns of ten steps.
void steps(const Options& options) {
  const Setup setup(options);
  const mesh::MachineMesh mesh = setup.mesh(options);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh);
  const reduction::ReducedModel reduced = reduction::read_model(options.model);
  const solver::LoadProgram load = setup.machine_case.load(options.load);
  const std::vector<double> ends = first_steps(load, options.steps);
  const solver::OperatingModel model(mesh.machine, system.layout);
  const std::vector<solver::Coefficients> c = coefficients(model, load, ends);
  solver::ThermalIntegrator full(system);
  reduction::ReducedStepper stepper(reduced.system);
  Eigen::MatrixXd state = full.uniform(load.initial_C() - mesh.machine.reference_C);
  Eigen::VectorXd small = stepper.uniform(load.initial_C() - mesh.machine.reference_C);
  double full_s = 0, reduced_s = 0;
  for (std::size_t first = 0; first < ends.size(); first += 10) {
    const std::size_t last = std::min(ends.size(), first + 10);
    const auto size = [&](std::size_t i) { return ends[i] - (i == 0 ? 0.0 : ends[i - 1]); };
    Watch time(options.threads);
    for (std::size_t i = first; i < last; ++i) full.advance(state, {c[i]}, size(i));
    full_s += time.seconds();
    time.restart();
    for (std::size_t i = first; i < last; ++i) stepper.advance(small, c[i], size(i));
    reduced_s += time.seconds();
  }
  const double count = ends.size();
  const mesh::Pose home = mesh::home_pose(mesh.machine);
  Watch time(options.threads);
  double sum = 0;
  for (int i = 0; i < 1000; ++i) sum += reduced.tcp(small, home).error[0];
  print("tcp", time.seconds() / 1000);
  print("tcp_um", 1e3 * sum);
  print("full", full_s / count);
  print("reduced", reduced_s / count);
  print("order", reduced.system.order());
  print("unknowns", system.size);
  // Sensors of both at the end: the same physics was run.
  print("sensors_apart_K", (full.sensors(state) - stepper.sensors(small)).cwiseAbs().maxCoeff());
}

/// A CSV of what a control sends once a second: speeds that change every minutes, axes that move.
void rows(const Options& options) {
  const reduction::ReducedModel model = reduction::read_model(options.model);
  const mesh::Machine& machine = model.machine;
  std::FILE* file = std::fopen(options.out.c_str(), "wb");
  if (file == nullptr)
    throw core::InputError(options.out.string(), "cannot be written", "a file in a folder with room");
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "time_s,spindle.speed_rpm,air.T_C");
  std::vector<const mesh::Axis*> linear;
  for (const mesh::Axis& axis : machine.axes)
    if (axis.kind == mesh::AxisKind::linear) linear.push_back(&axis);
  for (const mesh::Axis* axis : linear) fmt::format_to(out, ",axis.{0}.position_mm,axis.{0}.feed_mm_min", axis->id);
  for (const mesh::SensorSpec& sensor : machine.sensors) fmt::format_to(out, ",{}_C", sensor.id);
  text.push_back('\n');
  for (long i = 0; i < options.rows; ++i) {
    const double t = i;
    const double speed = i / 600 % 3 * 0.25 * machine.spindle_max_rpm;
    fmt::format_to(out, "{},{},{:.2f}", i, speed, machine.reference_C + 2.0 * std::sin(t / 14000.0));
    for (std::size_t a = 0; a < linear.size(); ++a) {
      const mesh::Axis& axis = *linear[a];
      const double middle = 0.5 * (axis.low + axis.high), reach = 0.45 * (axis.high - axis.low);
      fmt::format_to(out, ",{:.3f},{}", 1e3 * (middle + reach * std::sin(t / (7.0 + 3.0 * a))), 6000);
    }
    for (std::size_t s = 0; s < machine.sensors.size(); ++s)
      fmt::format_to(out, ",{:.3f}", machine.reference_C + 4.0 * (1.0 - std::exp(-t / (4000.0 + 3000.0 * s))));
    text.push_back('\n');
    if (text.size() > (1U << 20U) || i + 1 == options.rows) {
      const bool whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
      if (!whole) throw core::InputError(options.out.string(), "cannot be written", "a place with room on the disk");
      text.clear();
    }
  }
  if (std::fclose(file) != 0)
    throw core::InputError(options.out.string(), "cannot be written", "a place with room on the disk");
  print("rows", options.rows);
  print("order", model.system.order());
}

void control(const Options& options) {
  if (!options.folder.empty())
    bench::compared_rows(options.model, options.folder);
  else if (options.wall)
    bench::live_rows(options.model, options.rows);
  else
    bench::control_rows(options.model, options.rows);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"one piece of work of thermotwin, timed; started by tools/bench"};
  app.require_subcommand(1);
  Options options;
  const std::vector<std::pair<std::string, void (*)(const Options&)>> works = {
      {"files", write_files},   {"heat", heat},   {"memory", memory},  {"elastic", elastic},
      {"iterative", iterative}, {"loads", loads}, {"poses", poses},    {"steps", steps},
      {"online", online},       {"rows", rows},   {"control", control}};
  for (const auto& [name, work] : works) {
    CLI::App* verb = app.add_subcommand(name);
    verb->add_option("--case", options.case_path);
    verb->add_option("--size", options.size);
    verb->add_option("--body", options.body);
    verb->add_option("--set", options.set);
    verb->add_option("--load", options.load);
    verb->add_option("--folder", options.folder);
    verb->add_option("--model", options.model);
    verb->add_option("--out", options.out);
    verb->add_option("--steps", options.steps);
    verb->add_option("--threads", options.threads);
    verb->add_option("--columns", options.columns);
    verb->add_option("--order", options.order);
    verb->add_option("--deck-steps", options.decks);
    verb->add_option("--rows", options.rows);
    verb->add_flag("--apart", options.apart);
    verb->add_flag("--wall", options.wall);
    verb->callback([&options, work = work] {
      core::set_quiet(true);
      core::set_thread_count(options.threads);
      work(options);
    });
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 4;
  }
  return 0;
}
