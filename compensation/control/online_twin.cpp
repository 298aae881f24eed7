// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/online_twin.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "compensation/control/pause.h"
#include "compensation/control/probing.h"
#include "compensation/control/twin_jobs.h"
#include "compensation/control/twin_learned.h"
#include "compensation/control/twin_memory.h"
#include "core/error.h"
#include "core/missing.h"
#include "core/progress.h"
#include "core/range.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Status status_of(int status) {
  switch (status) {
    case TT_OK: return Status::ok;
    case TT_LIMITED:
    case TT_STARTING: return Status::limited;
    case TT_SENSOR_FAILED: return Status::sensor_failed;
    case TT_NO_SENSORS: return Status::no_sensors;
    case TT_OUTSIDE_WORKSPACE: return Status::outside_workspace;
    case TT_INPUT_MISSING: return Status::input_missing;
    default: return Status::failed;
  }
}

OffsetLimits limits_of(const ControlData& data) {
  OffsetLimits limits;
  limits.largest_um = data.largest_um;
  limits.rate_um_s = data.rate_um_s;
  limits.slope_um = Map<const VectorXd>(data.axis_slope_um.data(), std::ssize(data.axis_slope_um));
  limits.rapid = Map<const VectorXd>(data.axis_rapid.data(), std::ssize(data.axis_rapid));
  return limits;
}

void add_name(std::string& list, const char* name, const char* fault) {
  list += fmt::format("{}{}={}", list.empty() ? "" : " ", name, fault);
}

}  // namespace

struct OnlineTwin::Work {
  const reduction::ReducedModel& model;
  ControlOptions options;
  solver::OperatingModel operating;
  OutputMap map;
  ControlModel control;
  TwinMemory twin;
  OffsetLimits limits;
  Offsets offsets;
  std::vector<Index> absent;
  bool was_loaded = false;  ///< and no row has come since
  long probed = 0;
  TwinMeans means;

  Work(const reduction::ReducedModel& m, DerivedData derived, const ControlOptions& o)
      : model(m),
        options(o),
        operating(m.machine, m.system.layout),
        map(m),
        control(control_data(m, std::move(derived), o)),
        twin(control.model()),
        limits(limits_of(control.data())),
        means{0.0, VectorXd::Zero(control.data().terms), VectorXd::Zero(control.data().inputs),
              VectorXd::Zero(control.data().order), std::vector<long>(m.machine.sensors.size(), 0)} {
    offsets.offset_um = offsets.std_um = offsets.before_um = VectorXd::Zero(std::ssize(map.axes()));
  }

  const tt_model& data() const { return control.model(); }
  const tt_errors& errors() const { return twin->observer.errors; }
  RunningTwin running() const { return {model, operating, control, *twin.get()}; }
  double time() const { return twin->now->started != 0 ? twin->now->time : core::missing; }

  void check_row(double at, const VectorXd& told, const VectorXd& sensors_C) const {
    if (told.size() != data().channels) {
      throw core::InputError("online twin row", fmt::format("{} values", told.size()),
                             fmt::format("{}, one for each channel", data().channels));
    }
    if (sensors_C.size() != 0 && sensors_C.size() != data().sensors) {
      throw core::InputError("online twin sensors", fmt::format("{} readings", sensors_C.size()),
                             fmt::format("none or {}, one for each sensor", data().sensors));
    }
    if (!std::isfinite(at) || at <= time()) {
      const char* of_what = was_loaded ? " of the saved state" : "";
      throw core::InputError(
          "online twin time",
          std::isnan(time()) ? fmt::format("{} s", at) : fmt::format("{} s after {} s{}", at, time(), of_what),
          was_loaded ? "rows after the saved state; move the state away to start cold"
                     : "times that rise from row to row");
    }
  }

  /// Offsets of before the pause are no longer applied by anybody.
  void begin_offsets_anew() {
    twin->now->guarded = 0;
    std::fill_n(twin->offset_um, data().linear_axes, 0.0);
  }

  void tell_absent() {
    if (!was_loaded) {
      for (const Index channel : absent) tt_twin_never_given(twin.get(), channel);
      return;
    }
    // The state knows what its rows had; these rows may have other columns.
    std::fill_n(twin->untold, data().channels, 0);
    for (const Index channel : absent) twin->untold[channel] = 1;
  }

  void start_cold() {
    twin.begin_anew();
    was_loaded = false;
    tell_absent();
  }

  /// The first row after a saved state. @param sensors_C  its readings; nullptr: none
  void go_on(double at, const double* sensors_C) {
    const double pause = at - time();
    if (pause > static_cast<double>(TT_LONGEST_PAUSE_S)) {
      core::warn(fmt::format("the saved state is {:.1f} days older than the first row, more than {} days: cold start",
                             pause / 86400.0, TT_LONGEST_PAUSE_S / 86400));
      start_cold();
    } else if (pause > options.compensator.correction_s) {
      core::log_line(fmt::format("pause of {:.0f} s since the saved state: computed as a machine that is off", pause));
      tt_twin_pass_pause(twin.get(), at);
      begin_offsets_anew();
      if (tt_twin_contradicts_pause(twin.get(), sensors_C) != 0) {
        core::warn(
            fmt::format("the readings at {} s contradict a machine that was off for {:.0f} s: start anew from "
                        "the readings, as beside a warm machine",
                        at, pause));
        start_cold();
      }
    }
    was_loaded = false;
  }

  const Offsets& step(double at, const VectorXd& told, const VectorXd& sensors_C) {
    check_row(at, told, sensors_C);
    const bool has_readings = options.compensator.use_sensors && sensors_C.size() > 0;
    if (was_loaded) go_on(at, has_readings ? sensors_C.data() : nullptr);
    if (at - time() > longest_gap_s) {
      throw core::InputError("online twin time", fmt::format("{} s after {} s", at, time()),
                             fmt::format("rows at most {} s apart", longest_gap_s));
    }
    const double before = time();  // NaN before the first row
    offsets.before_um = Map<const VectorXd>(twin->offset_um, data().linear_axes);
    const int status = tt_twin_row(twin.get(), at, told.data(), has_readings ? sensors_C.data() : nullptr);
    if (!std::isnan(before)) means.add(at - before, has_readings ? sensors_C : VectorXd(), *twin.get());
    return write(at, status);
  }

  const Offsets& write(double at, int status) {
    const tt_twin* now = twin.get();
    offsets.time = at;
    offsets.status = status_of(status);
    offsets.offset_um = Map<const VectorXd>(now->offset_um, data().linear_axes);
    offsets.std_um = Map<const VectorXd>(now->std_um, data().linear_axes);
    offsets.failed_sensors.clear();
    for (int s = 0; s < data().sensors; ++s) {
      if (tt_twin_sensor_fault(now, s) != TT_SENSOR_FINE)
        add_name(offsets.failed_sensors, data().sensor_names[s], tt_twin_sensor_fault_text(now, s));
    }
    offsets.failed_inputs.clear();
    for (int k = 0; k < data().channels; ++k) {
      if (now->fault[k] != TT_FAULT_NONE)
        add_name(offsets.failed_inputs, data().channel_names[k], tt_fault_text(now->fault[k]));
    }
    return offsets;
  }

  mesh::Pose pose() const {
    const VectorXd row = Map<const VectorXd>(twin->row, data().channels);
    return operating.pose(row);
  }

  OutputMap::Projected projected(const double* outputs) const {
    const Index tool = data().tool_poses, table = data().table_poses;
    return {Map<const MatrixXd>(outputs, 6, tool), Map<const MatrixXd>(outputs + 6 * tool, 6, table),
            Map<const MatrixXd>(outputs + 6 * (tool + table), 7, table)};
  }

  solver::TcpError tcp(const mesh::Pose& at) const {
    if (twin->now->started == 0) return {solver::Vector6::Zero(), solver::Vector6::Zero(), solver::Vector6::Zero()};
    solver::TcpError error = map.tcp(projected(twin->base), projected(twin->slope), tt_share_ahead(twin.get()), at);
    if (data().observer == 0 || tt_errors_learns(&errors()) == 0) return error;
    double shares[tt_outputs];
    tt_errors_output_shares(&errors(), shares);
    for (int i = 0; i < 3; ++i) {
      error.tool[i] *= 1.0 + shares[i];
      error.table[i] *= 1.0 + shares[3 + i];
      error.error[i] = error.tool[i] - error.table[i] + shares[6 + i];
    }
    return error;
  }

  void probe(const mesh::Pose& at, const Eigen::Vector3d& error_um, double std_um) {
    if (twin->now->started == 0)
      throw core::InputError("compensator probe", "no row yet", "probing after the first row");
    check_probe(error_um, std_um);
    const Eigen::Vector3d error = error_um * core::units::um;
    probed += tt_twin_probe(twin.get(), at.data(), error.data(), std_um * core::units::um);
  }
};

OnlineTwin::OnlineTwin(const reduction::ReducedModel& model, const ControlOptions& options) {
  options.validate();
  work_ = std::make_unique<Work>(model, derived_data(model, options.tolerance), options);
}
OnlineTwin::OnlineTwin(const reduction::ReducedModel& model, DerivedData derived, const ControlOptions& options) {
  options.validate();
  work_ = std::make_unique<Work>(model, std::move(derived), options);
}
OnlineTwin::~OnlineTwin() = default;
OnlineTwin::OnlineTwin(OnlineTwin&&) noexcept = default;

const solver::Channels& OnlineTwin::channels() const { return work_->operating.channels(); }
const std::vector<std::string>& OnlineTwin::axes() const { return work_->map.axes(); }
const OffsetLimits& OnlineTwin::limits() const { return work_->limits; }

void OnlineTwin::never_told(const std::vector<Index>& channels) {
  for (const Index channel : channels)
    core::require_within("online twin never_told", channel, {0.0, work_->data().channels - 1.0});
  work_->absent = channels;
  work_->tell_absent();
}

const Offsets& OnlineTwin::step(double time, const VectorXd& row, const VectorXd& sensors_C) {
  return work_->step(time, row, sensors_C);
}

void OnlineTwin::probe(const mesh::Pose& pose, const Eigen::Vector3d& error_um, double std_um) {
  work_->probe(pose, error_um, std_um);
}

long OnlineTwin::probed() const { return work_->probed; }
std::vector<ErrorModel::State> OnlineTwin::learned() const { return learned_states(work_->running()); }
Detectability OnlineTwin::detectability() const { return compensation::detectability(work_->running(), work_->means); }
solver::TcpError OnlineTwin::tcp(const mesh::Pose& pose) const { return work_->tcp(pose); }

VectorXd OnlineTwin::std_um(const mesh::Pose& pose) const {
  const VectorXd offset_um = work_->map.offsets(work_->tcp(pose)) / core::units::um;
  VectorXd std_um(offset_um.size());
  tt_twin_std_at(work_->twin.get(), pose.data(), offset_um.data(), std_um.data());
  return std_um;
}

Eigen::Vector3d OnlineTwin::motion_um(const VectorXd& offset_um) const { return work_->map.motion(offset_um); }
mesh::Pose OnlineTwin::pose() const { return work_->pose(); }

VectorXd OnlineTwin::state() const {
  const tt_twin* now = work_->twin.get();
  const VectorXd own =
      Map<const VectorXd>(work_->data().observer != 0 ? now->observer.corrected : now->state, work_->data().order);
  return work_->model.system.capacity.llt().matrixU().solve(own);
}

VectorXd OnlineTwin::predicted_sensors_C() const {
  VectorXd predicted(work_->data().sensors);
  tt_twin_predicted_C(work_->twin.get(), predicted.data());
  return predicted;
}

VectorXd OnlineTwin::readings_C() const {
  const Index sensors = work_->data().sensors;
  if (work_->data().observer == 0) return VectorXd::Constant(sensors, core::missing);
  return Map<const VectorXd>(work_->twin->observer.reading_C, sensors);
}

std::vector<std::string> OnlineTwin::sensor_faults() const {
  std::vector<std::string> faults(work_->model.machine.sensors.size());
  for (std::size_t s = 0; s < faults.size(); ++s) {
    const int sensor = s;
    if (tt_twin_sensor_fault(work_->twin.get(), sensor) != TT_SENSOR_FINE)
      faults[s] = tt_twin_sensor_fault_text(work_->twin.get(), sensor);
  }
  return faults;
}

VectorXd OnlineTwin::wanted_um() const {
  return Map<const VectorXd>(work_->twin->wanted_um, work_->data().linear_axes);
}

GuardState OnlineTwin::guard() const {
  switch (work_->twin->now->guard) {
    case TT_FOLLOWING: return GuardState::following;
    case TT_GUARD_LIMITED: return GuardState::limited;
    case TT_HOLDING_STILL: return GuardState::holding;
    default: return GuardState::returning;
  }
}

double OnlineTwin::time() const { return work_->time(); }
std::string OnlineTwin::saved() const { return work_->twin.saved(); }

void OnlineTwin::load(std::string_view saved, const std::string& name) {
  work_->twin.load(saved, name);
  work_->was_loaded = work_->twin->now->started != 0;
}

void OnlineTwin::save_file(const std::filesystem::path& path) const { work_->twin.save_file(path); }

void OnlineTwin::load_file(const std::filesystem::path& path) {
  work_->twin.load_file(path);
  work_->was_loaded = work_->twin->now->started != 0;
}

void OnlineTwin::take_over(const OnlineTwin& other) {
  work_->twin.take_over(other.work_->twin);
  work_->was_loaded = work_->twin->now->started != 0;
  const tt_model& m = work_->data();
  for (int k = 0; k < m.channels; ++k)
    if (std::isnan(m.channel_default[k]) && m.channel_temperature[k] == 0) work_->twin->row[k] = core::missing;
}

Eigen::Vector<double, 9> OnlineTwin::output_shares() const {
  Eigen::Vector<double, 9> shares = Eigen::Vector<double, 9>::Zero();
  if (work_->data().observer != 0 && tt_errors_learns(&work_->errors()) != 0)
    tt_errors_output_shares(&work_->errors(), shares.data());
  return shares;
}

void OnlineTwin::pass_pause(double until) { tt_twin_pass_pause(work_->twin.get(), until); }

}  // namespace thermotwin::compensation
