// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/benchmarks/control_rows.h"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <numeric>
#include <utility>
#include <vector>

#include "compensation/control/control_model.h"
#include "compensation/control/twin.h"
#include "compensation/online/compensator.h"
#include "core/table.h"
#include "reduction/model/model_file.h"
#include "tools/benchmarks/stopwatch.h"

namespace thermotwin::bench {

namespace {

using Eigen::VectorXd;

constexpr double period_s = 0.1;
constexpr double start_over_s = 300.0;    ///< machine time that the work of the start is spread over
constexpr double short_step_s = 10.0;     ///< of the thermal state
constexpr std::size_t slowest_rows = 40;  ///< that are listed

double now(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return 1.0 * time.tv_sec + 1e-9 * time.tv_nsec;
}

/// A control's channels, row by row.
class Rows {
public:
  explicit Rows(const compensation::Compensator& compensator, const mesh::Machine& machine)
      : row_(compensator.channels().defaults()),
        speed_(compensator.channels().index("spindle.speed_rpm")),
        air_(compensator.channels().index("air.T_C")),
        most_(machine.spindle_max_rpm),
        reference_C_(machine.reference_C) {
    for (const mesh::Axis& axis : machine.axes) {
      if (axis.kind != mesh::AxisKind::linear) continue;
      moving_.push_back({compensator.channels().index("axis." + axis.id + ".position_mm"),
                         500.0 * (axis.low + axis.high), 450.0 * (axis.high - axis.low)});
    }
  }
  const VectorXd& at(double t) {
    if (speed_ >= 0) row_[speed_] = std::fmod(std::floor(t / 600.0), 3.0) * 0.25 * most_;
    if (air_ >= 0) row_[air_] = reference_C_ + 2.0 * std::sin(t / 14000.0);
    for (std::size_t a = 0; a < moving_.size(); ++a)
      row_[moving_[a].channel] = moving_[a].middle + moving_[a].reach * std::sin(t / (7.0 + 3.0 * a));
    return row_;
  }

private:
  struct Moving {
    int channel;
    double middle, reach;
  };
  VectorXd row_;
  int speed_, air_;
  double most_, reference_C_;
  std::vector<Moving> moving_;
};

void print_quantiles(const std::string& name, std::vector<double> times) {
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[std::min(times.size() - 1, static_cast<std::size_t>(share * times.size()))];
  };
  for (const auto& [word, share] : {std::pair{"median", 0.5}, {"999", 0.999}, {"9999", 0.9999}, {"most", 1.0}})
    print((name + "_" + word).c_str(), at(share));
}

/// A twin with the memory that it needs.
class Twin {
public:
  explicit Twin(const tt_model& model)
      : state_((tt_twin_state_bytes(&model) + 7) / 8),
        work_((tt_twin_work_bytes(&model) + 7) / 8) {
    begin(model);
  }
  Twin(const Twin&) = delete;
  Twin& operator=(const Twin&) = delete;
  void begin(const tt_model& model) { tt_twin_begin(&twin_, &model, state_.data(), work_.data()); }
  void row(double t, const VectorXd& row, const VectorXd& readings) {
    tt_twin_row(&twin_, t, row.data(), readings.size() > 0 ? readings.data() : nullptr);
  }
  const tt_twin& get() const { return twin_; }
  double state_kB() const { return 8e-3 * state_.size(); }
  double work_MB() const { return 8e-6 * work_.size(); }

private:
  std::vector<std::uint64_t> state_, work_;
  tt_twin twin_{};
};

/// Readings of a machine as the model has it, a tenth colder, that scatter.
class Sensors {
public:
  explicit Sensors(const tt_model& model)
      : machine_(model),
        readings_(model.sensors),
        reference_C_(model.reference_C) {}
  const VectorXd& at(double t, const VectorXd& row) {
    machine_.row(t, row, VectorXd());
    tt_twin_predicted_C(&machine_.get(), readings_.data());
    for (double& reading : readings_) {
      random_ = random_ * 1664525U + 1013904223U;
      reading += 0.1 * (reference_C_ - reading) + 0.05 * (1.0 * (random_ >> 8U) / 16777216.0 - 0.5);
    }
    return readings_;
  }

private:
  Twin machine_;
  VectorXd readings_;
  double reference_C_;
  std::uint32_t random_ = 1;
};

/// Times of one row each, s.
struct Times {
  std::vector<double> processor, wall;
};

void sleep_until(double time) {
  const double whole = std::floor(time);
  const timespec until{static_cast<time_t>(whole), static_cast<long>(1e9 * (time - whole))};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

/// @param step    (time, row, readings)
/// @param paced  the clock goes as the machine's time; else rows are as fast as they are taken
template <class Step>
Times measured(Rows& inputs, Sensors& sensors, long rows, const Step& step, bool paced = false) {
  Times times;
  times.processor.reserve(rows);
  times.wall.reserve(rows);
  const double begun = now(CLOCK_MONOTONIC);
  for (long i = 0; i < rows; ++i) {
    const double t = i * period_s;
    const VectorXd& row = inputs.at(t);
    const VectorXd& readings = sensors.at(t, row);
    if (paced) sleep_until(begun + t);
    const double wall_0 = now(CLOCK_MONOTONIC), own_0 = now(CLOCK_THREAD_CPUTIME_ID);
    step(t, row, readings);
    times.processor.push_back(now(CLOCK_THREAD_CPUTIME_ID) - own_0);
    times.wall.push_back(now(CLOCK_MONOTONIC) - wall_0);
  }
  return times;
}

void print_times(const std::string& name, Times times) {
  print_quantiles(name, std::move(times.processor));
  print_quantiles(name + "_wall", std::move(times.wall));
}

/// The same rows twice: the lower of both times of each row is what its own work takes, whatever else the machine did.
void measure_core(const std::string& name, const tt_model& model, Rows& inputs, long rows) {
  const auto run = [&] {
    Twin twin(model);
    Sensors sensors(model);
    return measured(inputs, sensors, rows,
                    [&](double t, const VectorXd& row, const VectorXd& readings) { twin.row(t, row, readings); });
  };
  Times first = run();
  const Times second = run();
  std::vector<double> lower = first.processor;
  for (std::size_t i = 0; i < lower.size(); ++i) lower[i] = std::min(lower[i], second.processor[i]);
  print_quantiles(name + "_lower", std::move(lower));
  print_times(name, std::move(first));
}

/// Takes the caches, as other programs do between two rows of a control.
class Evictor {
public:
  void run() {
    for (std::size_t i = 0; i < numbers_.size(); i += 8) numbers_[i] += 1;
  }

private:
  std::vector<std::uint64_t> numbers_ = std::vector<std::uint64_t>(std::size_t{1} << 24U);  // 128 MB
};

/// What a row found to do.
struct Work {
  int job = 0, phase = 0, slice = 0;
};

double bytes_of(const tt_model& m) {
  const double order = m.order;
  double columns = m.term_first[m.terms];
  double right = 0.0;
  for (int j = 0; j < m.terms; ++j)
    if (m.term_right_first[j] >= 0) right += m.term_first[j + 1] - m.term_first[j];
  return 8.0 * order * (order + columns + right + m.inputs + m.readings + 6.0 * m.tool_poses + 13.0 * m.table_poses);
}

}  // namespace

void control_rows(const std::filesystem::path& model_file, long rows) {
  const reduction::ReducedModel model = reduction::read_model(model_file);
  compensation::Compensator compensator(model);
  Rows inputs(compensator, model.machine);

  const Watch build;
  compensation::ControlOptions options;
  const compensation::ControlModel at_once(model, options);
  print("build", build.seconds());
  compensation::ControlData data = at_once.data();
  data.start_over_s = start_over_s;
  const compensation::ControlModel control(std::move(data));
  const tt_model& m = control.model();
  const Watch start;
  Twin twin(m);
  print("start", start.seconds());
  print("order", m.order);
  print("data_MB", 1e-6 * bytes_of(m));
  print("state_kB", twin.state_kB());
  print("work_MB", twin.work_MB());

  measure_core("core", m, inputs, rows);
  compensation::ControlData shorter = control.data();
  shorter.step_s = short_step_s;
  const compensation::ControlModel short_steps(std::move(shorter));
  measure_core("short", short_steps.model(), inputs, rows);
  {
    Sensors sensors(m);
    print_times("classes", measured(inputs, sensors, std::min(rows, 100000L),
                                    [&](double t, const VectorXd& row, const VectorXd& readings) {
                                      compensator.step(t, row, readings);
                                    }));
  }

  // Rows a minute apart: the largest difference of the offsets and of their deviations.
  compensation::Compensator other(model);
  twin.begin(at_once.model());
  Sensors sensors(at_once.model());
  double apart_um = 0.0, std_apart_um = 0.0, most_um = 0.0, first_row = 0.0;
  for (double t = 0.0; t <= 36000.0; t += 60.0) {
    const VectorXd& row = inputs.at(t);
    const VectorXd& readings = sensors.at(t, row);
    const Watch watch;
    twin.row(t, row, readings);
    if (t == 0.0) first_row = watch.seconds();
    const compensation::Offsets& offsets = other.step(t, row, readings);
    for (Eigen::Index a = 0; a < offsets.offset_um.size(); ++a) {
      apart_um = std::max(apart_um, std::abs(offsets.offset_um[a] - twin.get().offset_um[a]));
      std_apart_um = std::max(std_apart_um, std::abs(offsets.std_um[a] - twin.get().std_um[a]));
      most_um = std::max(most_um, std::abs(offsets.offset_um[a]));
    }
  }
  print("first_row", first_row);
  print("apart_um", apart_um);
  print("std_apart_um", std_apart_um);
  print("most_um", most_um);
}

void cold_rows(const std::filesystem::path& model_file, long rows) {
  const reduction::ReducedModel model = reduction::read_model(model_file);
  const compensation::Compensator compensator(model);
  Rows inputs(compensator, model.machine);
  compensation::ControlData data = compensation::control_data(model);
  data.start_over_s = start_over_s;
  const compensation::ControlModel control(std::move(data));
  Evictor evictor;
  std::vector<Work> works;
  const auto run = [&] {
    Twin twin(control.model());
    Sensors sensors(control.model());
    works.clear();
    Times times;
    for (long i = 0; i < rows; ++i) {
      const double t = i * period_s;
      const VectorXd& row = inputs.at(t);
      const VectorXd& readings = sensors.at(t, row);
      const tt_numbers& found = *twin.get().now;
      works.push_back({found.job, found.phase, found.slices_done});
      evictor.run();
      const double own_0 = now(CLOCK_THREAD_CPUTIME_ID);
      twin.row(t, row, readings);
      times.processor.push_back(now(CLOCK_THREAD_CPUTIME_ID) - own_0);
    }
    return times.processor;
  };
  std::vector<double> lower = run();
  const std::vector<double> second = run();
  for (std::size_t i = 0; i < lower.size(); ++i) lower[i] = std::min(lower[i], second[i]);
  std::vector<std::size_t> order(lower.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return lower[a] > lower[b]; });
  for (std::size_t k = 0; k < std::min<std::size_t>(order.size(), slowest_rows); ++k) {
    const Work& work = works[order[k]];
    print(fmt::format("slow_{}_job_{}_phase_{}_slice_{}", order[k], work.job, work.phase, work.slice).c_str(),
          lower[order[k]]);
  }
  print_quantiles("cold_lower", std::move(lower));
}

void live_rows(const std::filesystem::path& model_file, long rows) {
  const reduction::ReducedModel model = reduction::read_model(model_file);
  const compensation::Compensator compensator(model);
  Rows inputs(compensator, model.machine);
  compensation::ControlData data = compensation::control_data(model);
  data.start_over_s = start_over_s;
  const compensation::ControlModel control(std::move(data));
  Twin twin(control.model());
  Sensors sensors(control.model());
  print_times("live",
              measured(
                  inputs, sensors, rows,
                  [&](double t, const VectorXd& row, const VectorXd& readings) { twin.row(t, row, readings); }, true));
}

void compared_rows(const std::filesystem::path& model_file, const std::filesystem::path& folder) {
  const reduction::ReducedModel model = reduction::read_model(model_file);
  const core::Table inputs = core::read_csv(folder / "inputs.csv"), sensors = core::read_csv(folder / "sensors.csv");
  const compensation::ControlModel control(model);
  Twin twin(control.model());
  compensation::Compensator dense(model);
  VectorXd row = dense.channels().defaults(), readings(std::ssize(model.machine.sensors));
  double apart_um = 0.0, std_apart_um = 0.0, most_um = 0.0;
  for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
    for (Eigen::Index c = 1; c < inputs.values.cols(); ++c)
      row[dense.channels().index(inputs.columns[c])] = inputs.values(i, c);
    for (Eigen::Index s = 0; s < readings.size(); ++s)
      readings[s] = sensors.values(i, *sensors.find(model.machine.sensors[s].id + "_C"));
    const double t = inputs.values(i, 0);
    twin.row(t, row, readings);
    const compensation::Offsets& offsets = dense.step(t, row, readings);
    for (Eigen::Index a = 0; a < offsets.offset_um.size(); ++a) {
      apart_um = std::max(apart_um, std::abs(offsets.offset_um[a] - twin.get().offset_um[a]));
      std_apart_um = std::max(std_apart_um, std::abs(offsets.std_um[a] - twin.get().std_um[a]));
      most_um = std::max(most_um, std::abs(offsets.offset_um[a]));
    }
  }
  print("rows", static_cast<double>(inputs.rows()));
  print("apart_um", apart_um);
  print("std_apart_um", std_apart_um);
  print("most_um", most_um);
}

}  // namespace thermotwin::bench
