// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/compensator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "compensation/online/observer.h"
#include "compensation/online/offset_output.h"
#include "compensation/online/state_clock.h"
#include "core/error.h"
#include "core/range.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "mesh/machine/plausible_range.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// An input leaps if it changes by more than this share of itself from row to row.
constexpr double leap_share = 0.2;

/// Channels that may leap: speeds, feeds, powers, states.
std::vector<Index> leaping_channels(const std::vector<std::string>& names) {
  constexpr const char* endings[] = {"_rpm", "_min", ".power_W", ".on", ".open"};
  std::vector<Index> leaping;
  for (Index k = 0; k < std::ssize(names); ++k) {
    if (std::any_of(std::begin(endings), std::end(endings), [&](const char* e) { return names[k].ends_with(e); }))
      leaping.push_back(k);
  }
  return leaping;
}

void require_limit(const char* option, double value, double low, double high) {
  core::require_option(value == 0.0 || (value >= low && value <= high), option, value,
                       fmt::format("{} to {}, or 0 (by the model)", low, high));
}

}  // namespace

void CompensatorOptions::validate() const {
  for (const auto& [name, value] : {std::pair{"step_s", step_s}, {"correction_s", correction_s}}) {
    core::require_option(value >= 1e-3 && value <= 86400.0, std::string("compensator ") + name, value,
                         "0.001 s to 86400 s");
  }
  mesh::PlausibleRange{-50.0, 100.0}.require(start_C, "compensator start_C");  // as --start-C
  require_limit("compensator largest_um", largest_um, 1e-3, largest_offset_um);
  require_limit("compensator rate_um_s", rate_um_s, least_rate_um_s, largest_rate_um_s);
}

void StreamOptions::validate() const { check_probe_std(probe_std_um); }

struct Compensator::Work {
  const reduction::ReducedModel& model;
  CompensatorOptions options;
  solver::OperatingModel operating;
  StateClock clock;
  Observer observer;
  OffsetOutput output;

  bool started = false;
  std::vector<Index> leaping;
  std::vector<char> never_told;  ///< (channels) 1 or 0
  std::vector<char> untold;      ///< (drives) of the last row
  VectorXd row, row_before, given, given_at;
  const VectorXd no_readings;
  long probed = 0;

  Work(const reduction::ReducedModel& m, const CompensatorOptions& o)
      : model(m),
        options(o),
        operating(m.machine, m.system.layout),
        clock(m, operating, options.step_s),
        observer(m, operating, options, clock),
        output(m, options),
        leaping(leaping_channels(operating.channels().names())),
        never_told(operating.channels().size(), 0),
        row(operating.channels().defaults()),
        given_at(VectorXd::Constant(row.size(), -std::numeric_limits<double>::infinity())) {
    clock.set_state(m.system.one_kelvin * (options.start_C - m.machine.reference_C));
  }

  mesh::Pose pose() const { return operating.pose(row); }
  solver::TcpError tcp(const mesh::Pose& at) const { return output.tcp(observer.errors(), clock.share_ahead(), at); }

  void check_row(double at, const VectorXd& told, const VectorXd& sensors_C) const {
    if (told.size() != row.size()) {
      throw core::InputError("compensator row", fmt::format("{} values", told.size()),
                             fmt::format("{}, one for each channel", row.size()));
    }
    const auto sensors = std::ssize(model.machine.sensors);
    if (sensors_C.size() != 0 && sensors_C.size() != sensors) {
      throw core::InputError("compensator sensors", fmt::format("{} readings", sensors_C.size()),
                             fmt::format("none or {}, one for each sensor", sensors));
    }
    const double time = clock.time();
    if (!std::isfinite(at) || (started && !(at > time))) {
      throw core::InputError("compensator time",
                             started ? fmt::format("{} s after {} s", at, time) : fmt::format("{} s", at),
                             "times that rise from row to row");
    }
    if (started && at - time > longest_gap_s) {
      throw core::InputError("compensator time", fmt::format("{} s after {} s", at, time),
                             fmt::format("rows at most {} s apart", longest_gap_s));
    }
  }

  /// Drives whose speed was never told, or not for a while, since the row before.
  void add_drives(double at) {
    const std::vector<DriveHeat>& drives = observer.errors().drives();
    untold.assign(drives.size(), 0);
    for (Index d = 0; d < std::ssize(drives); ++d) {
      const Index k = drives[d].channel;
      untold[d] = never_told[k] != 0 || (std::isnan(given[k]) && at - given_at[k] > options.correction_s);
    }
    observer.add_drives(untold, row, at - clock.time());
  }

  /// @return whether an input is missing
  bool take_inputs(double at, const VectorXd& told) {
    given = told;
    observer.take_out_inputs(given);
    bool missing_input = observer.trust().any_input_out();
    const VectorXd& defaults = operating.channels().defaults();
    row_before = row;
    operating.channels().update(given, row);
    for (Index k = 0; k < given.size(); ++k) {
      if (!std::isnan(given[k])) {
        given_at[k] = at;
      } else {
        // The last value holds for a while; then it is no longer news.
        missing_input = missing_input || (!std::isnan(defaults[k]) && at - given_at[k] > options.correction_s);
      }
    }
    return missing_input;
  }

  bool inputs_leapt() const {
    return std::any_of(leaping.begin(), leaping.end(), [&](Index k) {
      return std::abs(row[k] - row_before[k]) > leap_share * std::max(std::abs(row[k]), std::abs(row_before[k]));
    });
  }

  /// Ends the step of the state at the last row's time.
  void close_step() {
    const StateClock::Step step = clock.take_step();
    for (int i = 0; i < step.parts; ++i) {
      // A row that lasts for hours is no reason for sensitivities in one step.
      if (observer.due()) correct();
      clock.advance(step.mean, observer.guide_readings(), step.part_s);
    }
    clock.end_step();
    if (step.parts == 0) return;
    observer.show(step.duration);
    observer.set_corrected();
    output.set_state(observer.corrected());
    output.set_change(clock.change() + clock.last_step() * observer.correction_rate());
  }

  void correct() {
    observer.correct();
    show_correction();
  }

  void show_correction() {
    output.set_state(observer.corrected());
    output.set_covariance(observer.errors());
  }

  /// The time since the row before, at whose end this row's readings were taken.
  void advance(double at) {
    // What came before this row is closed first if both together would be too long a step.
    if (clock.ends_before(at - clock.time())) {
      close_step();
      if (observer.due()) correct();
    }
    clock.add(row, at);
    if (clock.full()) close_step();
    observer.add_readings(inputs_leapt());
    if (clock.step_end() == clock.time() && observer.due()) correct();
  }

  const Offsets& step(double at, const VectorXd& told, const VectorXd& sensors_C) {
    check_row(at, told, sensors_C);
    const bool missing_input = take_inputs(at, told);
    observer.read(options.use_sensors ? sensors_C : no_readings, row);
    if (started) {
      add_drives(at);
      advance(at);
    } else {
      observer.start(at, row);
      started = true;
      show_correction();
    }
    const SensorTrust& trust = observer.trust();
    return output.write(at, pose(), observer.errors(), clock.share_ahead(),
                        {missing_input, !observer.any_reading() && !trust.any_sensor_out(), trust.failed_sensors(),
                         trust.failed_inputs()});
  }

  void probe(const mesh::Pose& at, const Eigen::Vector3d& error_um, double std_um) {
    if (!started) throw core::InputError("compensator probe", "no row yet", "probing after the first row");
    check_probe(error_um, std_um);
    if (!error_um.array().isFinite().any()) return;
    if (clock.interval_s() > 0.0) correct();  // sensitivities of now
    ErrorModel::ErrorRows rows;
    output.map().rows(at, rows.tool, rows.table);
    observer.learn(rows, error_um * core::units::um, std::hypot(std_um * core::units::um, output.model_error()));
    for (const double value : error_um) probed += std::isfinite(value);
    show_correction();
  }
};

Compensator::Compensator(const reduction::ReducedModel& model, const CompensatorOptions& options) {
  options.validate();
  work_ = std::make_unique<Work>(model, options);
}
Compensator::~Compensator() = default;
Compensator::Compensator(Compensator&&) noexcept = default;

const solver::Channels& Compensator::channels() const { return work_->operating.channels(); }
const std::vector<std::string>& Compensator::axes() const { return work_->output.map().axes(); }
const OffsetLimits& Compensator::limits() const { return work_->output.limits(); }

const Offsets& Compensator::step(double time, const Eigen::VectorXd& row, const Eigen::VectorXd& sensors_C) {
  return work_->step(time, row, sensors_C);
}

void Compensator::rested() {
  if (work_->options.use_sensors)
    throw core::InputError("compensator rested", "a machine with sensors", "use_sensors = false");
  if (work_->started) throw core::InputError("compensator rested", "a row was taken", "a call before the first row");
  work_->observer.rested();
}

void Compensator::never_told(const std::vector<Eigen::Index>& channels) {
  for (const Eigen::Index channel : channels) {
    core::require_within("compensator never_told", channel, {0.0, work_->never_told.size() - 1.0});
    work_->never_told[channel] = 1;
  }
  const int air = work_->operating.channels().index("air.T_C");
  if (air >= 0 && work_->never_told[air] != 0) work_->observer.air_is_untold();
}

solver::TcpError Compensator::tcp(const mesh::Pose& pose) const { return work_->tcp(pose); }

Eigen::VectorXd Compensator::std_um(const mesh::Pose& pose) const {
  return work_->output.std_um(work_->observer.errors(), work_->clock.share_ahead(), pose);
}

void Compensator::probe(const mesh::Pose& pose, const Eigen::Vector3d& error_um, double std_um) {
  work_->probe(pose, error_um, std_um);
}

long Compensator::probed() const { return work_->probed; }
std::vector<ErrorModel::State> Compensator::learned() const { return work_->observer.errors().states(); }
Detectability Compensator::detectability() const { return work_->observer.detectability(); }

Eigen::Vector3d Compensator::motion_um(const Eigen::VectorXd& offset_um) const {
  return work_->output.map().motion(offset_um);
}

mesh::Pose Compensator::pose() const { return work_->pose(); }
Eigen::VectorXd Compensator::state() const { return work_->observer.corrected(); }

Eigen::VectorXd Compensator::predicted_sensors_C() const { return work_->observer.predicted_sensors_C(); }

}  // namespace thermotwin::compensation
