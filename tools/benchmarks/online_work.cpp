// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/benchmarks/online_work.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <string>
#include <vector>

#include "core/error.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/projection.h"
#include "reduction/model/exact_stepper.h"
#include "reduction/model/model_file.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/operation/layout.h"
#include "tools/benchmarks/control_rows.h"
#include "tools/benchmarks/stopwatch.h"

namespace thermotwin::bench {

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
    compared_rows(options.model, options.folder);
  else if (options.wall)
    live_rows(options.model, options.rows);
  else if (options.cold)
    cold_rows(options.model, options.rows);
  else
    control_rows(options.model, options.rows);
}

}  // namespace thermotwin::bench
