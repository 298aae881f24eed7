// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensation/compensator.h"
#include "compensation/data_models.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
constexpr double day_s = 86400.0;

struct Part {
  std::string name;
  double from, to;  ///< [from, to)
};

/// The training part, then what is left of each day (24 h by the record's own time) that has rows.
std::vector<Part> parts_of(const VectorXd& time, double train_until) {
  constexpr std::size_t most = 100;  // a record of years: the rest in one part
  constexpr double forever = std::numeric_limits<double>::infinity();
  std::vector<Part> parts;
  double day = 0.0;
  for (Index i = 0; i < time.size(); ++i) {
    const bool training = time[i] < train_until;
    const double at_day = std::floor(time[i] / day_s);
    const bool begins = parts.empty() || (!training && (parts.back().name == "training" || at_day != day));
    if (!begins || parts.size() == most) continue;
    if (!parts.empty()) parts.back().to = parts.back().name == "training" ? train_until : (day + 1.0) * day_s;
    day = at_day;
    parts.push_back({training ? "training" : fmt::format("day {:.0f}", day), time[i], forever});
  }
  if (!parts.empty()) parts.back().to = std::nextafter(time[time.size() - 1], forever);
  return parts;
}

VectorXd within(const VectorXd& time, const VectorXd& values, const Part& part) {
  VectorXd inside = values;
  for (Index i = 0; i < time.size(); ++i) {
    if (time[i] < part.from || time[i] >= part.to) inside[i] = missing;
  }
  return inside;
}

VectorXd zeroed(const VectorXd& values, Index at) { return at < 0 ? values : VectorXd(values.array() - values[at]); }

Index first_known(const VectorXd& values) {
  for (Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) return i;
  }
  return -1;
}

class Evaluator {
 public:
  Evaluator(const Measurement& measurement, const EvaluateOptions& options)
      : measurement_(measurement), time_(measurement.time()), parts_(parts_of(time_, options.train_until_s)) {
    result_.predictions.source = "predictions";
    add_column("time_s", time_);
    for (const MeasuredChannel& channel : measurement.channels) {
      if (channel.kind == ChannelKind::displacement) displacements_.push_back(&channel);
    }
    for (const MeasuredChannel* channel : displacements_) {
      const VectorXd raw = measurement.values(*channel);
      measured_.push_back(channel->zero == Zero::first ? zeroed(raw, first_known(raw)) : raw);
      add_column(channel->id + "_measured", measured_.back());
    }
  }

  const std::vector<const MeasuredChannel*>& displacements() const { return displacements_; }
  const VectorXd& measured(std::size_t channel) const { return measured_[channel]; }
  const VectorXd& time() const { return time_; }
  void note(std::string text) { result_.notes.push_back(std::move(text)); }

  void judge(const std::string& model, std::size_t channel, const VectorXd& predicted) {
    for (const Part& part : parts_) {
      const Measures measures = measure(within(time_, measured_[channel], part), predicted);
      if (measures.count == 0) continue;
      result_.rows.push_back({model, displacements_[channel]->id, part.name, part.from, part.to, measures, displacements_[channel]->unit});
    }
    add_column(displacements_[channel]->id + "_" + model, predicted);
  }

  Evaluation finish() {
    result_.predictions.values.resize(time_.size(), static_cast<Index>(columns_.size()));
    for (std::size_t i = 0; i < columns_.size(); ++i) result_.predictions.values.col(static_cast<Index>(i)) = columns_[i];
    return std::move(result_);
  }

 private:
  void add_column(const std::string& name, const VectorXd& values) {
    result_.predictions.columns.push_back(name);
    columns_.push_back(values);
  }

  const Measurement& measurement_;
  VectorXd time_;
  std::vector<Part> parts_;
  std::vector<const MeasuredChannel*> displacements_;
  std::vector<VectorXd> measured_, columns_;
  Evaluation result_;
};

void evaluate_data_models(const Measurement& measurement, const EvaluateOptions& options, Evaluator& evaluator) {
  std::vector<const MeasuredChannel*> temperatures;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind == ChannelKind::temperature) temperatures.push_back(&channel);
  }
  if (temperatures.empty()) {
    evaluator.note("no temperature channel: regression and transfer functions left out");
    return;
  }
  const VectorXd& time = evaluator.time();
  Eigen::MatrixXd inputs(time.size(), static_cast<Index>(temperatures.size()));
  for (std::size_t i = 0; i < temperatures.size(); ++i) inputs.col(static_cast<Index>(i)) = measurement.values(*temperatures[i]);
  Index train = 0, incomplete = 0;
  for (Index i = 0; i < time.size(); ++i) {
    train += time[i] < options.train_until_s;
    incomplete += !inputs.row(i).allFinite();
  }
  if (incomplete > 0) evaluator.note(fmt::format("{} rows without all temperatures are left out", incomplete));
  if (train == time.size()) evaluator.note("all data are training data: nothing is left to judge the fitted models on");
  for (auto make : {make_static_regression, make_first_order}) {
    for (std::size_t c = 0; c < evaluator.displacements().size(); ++c) {
      const std::unique_ptr<DataModel> model = make();
      const std::string label = model->name() + " " + evaluator.displacements()[c]->id;
      try {
        model->fit(time.head(train), inputs.topRows(train), evaluator.measured(c).head(train));
      } catch (const core::InputError& error) {
        evaluator.note(label + " left out: " + error.what());
        continue;
      }
      evaluator.note(label + ": " + model->explain());
      evaluator.judge(model->name(), c, model->predict(time, inputs));
    }
  }
}

/// Errors in the frame of the table where the channel asks for it.
void turn_into_frame(std::vector<solver::TcpError>& errors, const MeasuredChannel& channel, const mesh::Machine& machine,
                     const mesh::Pose& pose) {
  if (channel.frame != "table") return;
  const Eigen::Matrix3d to_table =
      mesh::body_transform(machine, machine.body_index(machine.tcp.table_body), pose).linear().transpose();
  for (solver::TcpError& error : errors) {
    for (solver::Vector6* part : {&error.error, &error.tool, &error.table}) {
      part->head<3>() = (to_table * part->head<3>()).eval();
      part->tail<3>() = (to_table * part->tail<3>()).eval();
    }
  }
}

/// Uniform start of the run without sensors: what a control knows is the air.
double start_temperature(const Measurement& measurement, const mesh::Machine& machine) {
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.input != "air.T_C") continue;
    const VectorXd values = measurement.values(channel);
    if (const Index first = first_known(values); first >= 0) return values[first];
  }
  return machine.reference_C;
}

void evaluate_reduced_model(const Measurement& measurement, const reduction::ReducedModel& model, bool with_sensors,
                            Evaluator& evaluator) {
  require_fits(measurement, model.machine);
  CompensatorOptions options;
  options.use_sensors = options.start_from_sensors = with_sensors;
  options.start_C = start_temperature(measurement, model.machine);
  Compensator compensator(model, options);

  const VectorXd& time = evaluator.time();
  const Eigen::MatrixXd rows = channel_rows(measurement, compensator.channels());
  Eigen::MatrixXd readings = Eigen::MatrixXd::Constant(time.size(), static_cast<Index>(model.machine.sensors.size()), missing);
  for (const MeasuredChannel& channel : measurement.channels) {
    if (with_sensors && !channel.sensor.empty()) {
      readings.col(model.machine.sensor_index(channel.sensor)) = measurement.values(channel);
    }
  }
  const std::vector<const MeasuredChannel*>& displacements = evaluator.displacements();
  std::vector<mesh::Pose> poses;
  for (const MeasuredChannel* channel : displacements) {
    poses.push_back(mesh::parse_pose(model.machine, channel->pose_text, channel->id));
  }
  std::vector<std::vector<solver::TcpError>> errors(displacements.size());
  VectorXd row;
  for (Index i = 0; i < time.size(); ++i) {
    // Row i of a measurement holds until i + 1; the compensator is told what held since its last row.
    row = rows.row(std::max<Index>(i - 1, 0)).transpose();
    compensator.step(time[i], row, readings.row(i).transpose());
    for (std::size_t k = 0; k < poses.size(); ++k) errors[k].push_back(compensator.tcp(poses[k]));
  }
  const std::string name = with_sensors ? "reduced_model_sensors" : "reduced_model";
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const MeasuredChannel& channel = *displacements[k];
    turn_into_frame(errors[k], channel, model.machine, poses[k]);
    const VectorXd predicted = quantity_series(errors[k], channel);
    const Index zero = channel.zero == Zero::first ? first_known(measurement.values(channel)) : -1;
    evaluator.judge(name, k, zeroed(predicted, zero));
  }
  if (!with_sensors) evaluator.note(fmt::format("reduced_model: nothing fitted; starts uniform at {:.2f} degC", options.start_C));
}

std::string number(double value, const char* format = "{:.2f}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

}  // namespace

VectorXd quantity_series(const std::vector<solver::TcpError>& errors, const MeasuredChannel& channel) {
  static constexpr const char* direct[] = {"dx", "dy", "dz", "ra", "rb", "rc"};
  static constexpr char iso[] = {'X', 'Y', 'Z', 'A', 'B', 'C'};
  const std::string& quantity = channel.quantity;
  int component = -1;
  double sign = 1.0;
  for (int i = 0; i < 6; ++i) {
    if (quantity == direct[i]) component = i;
    // An ISO location error is where the axis (or the table) went; the TCP error is tool - table.
    if (quantity.size() == 3 && quantity[1] == '0' && quantity[0] == iso[i]) {
      component = i;
      sign = -1.0;
    }
  }
  if (component < 0) {
    throw core::InputError("channel '" + channel.id + "'", "quantity '" + quantity + "'",
                           "a displacement or rotation of the TCP at a pose: dx dy dz ra rb rc X0C Y0C Z0T A0C B0C");
  }
  const double scale = sign / (component < 3 ? core::units::um : core::units::um_per_m);
  VectorXd values(static_cast<Index>(errors.size()));
  for (Index i = 0; i < values.size(); ++i) values[i] = scale * errors[static_cast<std::size_t>(i)].error[component];
  return values;
}

Evaluation evaluate(const Measurement& measurement, const reduction::ReducedModel* model, const EvaluateOptions& options) {
  Evaluator evaluator(measurement, options);
  if (evaluator.displacements().empty()) {
    throw core::InputError((measurement.folder / "channels.toml").string(), "no channel of kind displacement",
                           "at least one, since models are compared on displacements");
  }
  evaluate_data_models(measurement, options, evaluator);
  if (model != nullptr) {
    evaluate_reduced_model(measurement, *model, false, evaluator);
    const bool any_sensor = std::any_of(measurement.channels.begin(), measurement.channels.end(),
                                        [](const MeasuredChannel& channel) { return !channel.sensor.empty(); });
    if (any_sensor) evaluate_reduced_model(measurement, *model, true, evaluator);
  }
  return evaluator.finish();
}

std::string Evaluation::brief() const {
  std::vector<std::vector<std::string>> table = {
      {"model", "channel", "part", "rows", "rms before", "rms after", "reduction %", "PK before", "PK after", "reduction %", "fit %", "unit"}};
  for (const EvaluationRow& row : rows) {
    const Measures& m = row.measures;
    table.push_back({row.model, row.channel, row.part, std::to_string(m.count), number(m.rms_before, "{:.3f}"), number(m.rms, "{:.3f}"),
                     number(m.rms_reduction_percent, "{:.1f}"), number(m.peak_to_peak_before), number(m.peak_to_peak),
                     number(m.peak_to_peak_reduction_percent, "{:.1f}"), number(m.fit, "{:.1f}"), row.unit});
  }
  std::string text = core::format_table(table);
  for (const std::string& line : notes) text += "  " + line + "\n";
  return text;
}

}  // namespace thermotwin::compensation
