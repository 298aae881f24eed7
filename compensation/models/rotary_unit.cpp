// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/rotary_unit.h"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compensation/models/least_squares.h"
#include "compensation/models/parameter_store.h"
#include "compensation/models/rotary_bodies.h"
#include "core/error.h"
#include "core/first_order_lag.h"
#include "core/missing.h"

namespace thermotwin::compensation {
namespace rotary {
namespace {

using core::missing;

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr Index most_unit_blocks = 700;
constexpr double noise_share = 0.05;
constexpr int most_refinements = 25;

class RotaryUnit final : public ChannelModel {
public:
  RotaryUnit() = default;

  void fit(const TrainingData& data) override {
    throw InputError(data.label, "one channel by itself", "all channels of the unit together");
  }

  std::string caution() const override { return doubt; }
  std::unique_ptr<RowPredictor> start() const override { return std::make_unique<Predictor>(*this); }

  std::string explain(const std::string& unit) const override {
    std::string text = fmt::format("layout {}, k1 {:.3g}, k2 {:.3g} s, intercept {:.3g} {}, rms of the fit {:.3g} {};",
                                   roles.a_c ? "A/C" : "B/C", gain, lag_s, intercept, unit, rms, unit);
    for (Index i = 0; i < places; ++i) {
      const bool by_power =
          (i == loss_c || i == power_c) ? roles.c_power >= 0 : (i == loss_s || i == power_s) && roles.s_power >= 0;
      if (!by_power) text += fmt::format(" {} {:.3g} {},", parameters[i].name, std::exp(logs[i]), parameters[i].unit);
    }
    text.pop_back();
    return text;
  }

  void save(ParameterStore& store) const override {
    store.put("parameters", logs);
    store.put("roles", roles.pack());
    store.put("full_speeds", full);
    store.put("geometry", row);
    store.put("gain", gain);
    store.put("lag_s", lag_s);
    store.put("intercept", intercept);
    store.put("rms", rms);
  }

  void load(const ParameterStore& store, const std::vector<InputInfo>& info) override {
    logs = store.vector("parameters", places);
    const VectorXd packed = store.vector("roles", 7);
    for (Index i = 0; i < 6; ++i) {
      if (!(packed[i] >= -1.0 && packed[i] < info.size()))
        throw InputError(store.place() + " roles", fmt::format("{}", packed[i]), "places of inputs");
    }
    roles = Roles::unpack(packed);
    full = store.vector("full_speeds", 3);
    row = store.vector("geometry", bodies);
    gain = store.number("gain");
    lag_s = store.number("lag_s");
    intercept = store.number("intercept");
    rms = store.number("rms", 0.0);
    if (!(lag_s >= 0.0) || !(logs.cwiseAbs().maxCoeff() < 50.0)) {
      throw InputError(store.place() + " lag_s", fmt::format("{}", lag_s),
                       "a number of at least 0, and parameters of usual size");
    }
  }

  VectorXd logs, full, row;
  Roles roles;
  double gain = 0, lag_s = 0, intercept = 0, rms = 0;
  std::string doubt;  ///< of the fit

private:
  class Predictor final : public RowPredictor {
  public:
    explicit Predictor(const RotaryUnit& model) : model_(model), unit_(model.logs, model.roles, model.full) {}
    double step(double time, const Eigen::Ref<const RowVectorXd>& inputs) override {
      if (held_.size() == 0) {
        if (!inputs.allFinite()) return missing;
        held_ = inputs;
        unit_.start(inputs);
        reference_ = unit_.temperature();
        time_ = time;
        return model_.intercept;
      }
      const double duration = time - time_;
      unit_.advance(unit_.drive(held_), duration);
      time_ = time;
      const double raw = model_.row.dot(unit_.temperature() - reference_);
      rise_ = core::LagStep(duration, model_.lag_s).standing(rise_, raw);
      const bool complete = inputs.allFinite();
      for (Index k = 0; k < inputs.size(); ++k) {
        if (std::isfinite(inputs[k])) held_[k] = inputs[k];
      }
      return complete ? model_.gain * rise_ + model_.intercept : missing;
    }

  private:
    const RotaryUnit& model_;
    Unit unit_;
    RowVectorXd held_;
    Temperatures reference_ = Temperatures::Zero();
    double time_ = 0, rise_ = 0;  ///< rise_: behind the lag, of a drive that holds over each interval
  };
};

/// One displacement of the unit as it enters the fit.
struct Target {
  std::size_t channel;
  TrainingData data;
  VectorXd row;
  double spread;
  bool averaged;
};

/// Standard deviation of what is known, from plain sums.
struct Scatter {
  double count = 0, variance = 0;
};
Scatter scatter_of(const VectorXd& values) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value;
    squares += value * value;
    count += 1.0;
  }
  return {count, count > 0.0 ? squares / count - sum / count * (sum / count) : 0.0};
}

/// @param left_out  gets a line for each channel that cannot take part
std::vector<Target> find_targets(const std::vector<UnitChannel>& channels, bool a_c,
                                 std::vector<std::string>& left_out) {
  std::vector<Target> targets;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const VectorXd row = geometry(channels[i].quantity, a_c);
    if (row.size() == 0) {
      left_out.push_back(channels[i].data.label + fmt::format(": quantity '{}' is not in the equations of layout {}",
                                                              channels[i].quantity, a_c ? "A/C" : "B/C"));
      continue;
    }
    Blocks blocks = make_blocks(channels[i].data, most_unit_blocks);
    const Scatter scatter = scatter_of(blocks.data.target);
    if (scatter.count < 12.0 || !(scatter.variance > 0.0)) {
      left_out.push_back(channels[i].data.label + ": a constant displacement, or fewer than 12 rows");
      continue;
    }
    targets.push_back({i, std::move(blocks.data), row, std::sqrt(scatter.variance), blocks.averaged});
  }
  return targets;
}

/// Least squares in the unit's logarithms, then a log lag for each channel; gains and intercepts of the channels
/// are solved for at each.
class UnitFit {
public:
  UnitFit(const std::vector<Target>& targets, const Roles& roles, const VectorXd& full)
      : targets_(targets),
        roles_(roles),
        full_(full),
        start_(places + std::ssize(targets)),
        spread_(start_.size()) {
    const auto count = std::ssize(targets);
    start_.head(places) = usual_parameters();
    for (Index i = 0; i < places; ++i) spread_[i] = parameters[i].spread;
    constexpr double usual_lag_s = 120.0, lag_spread = 1.5;
    start_.tail(count).setConstant(std::log(usual_lag_s));
    spread_.tail(count).setConstant(lag_spread);
  }

  /// @throws InputError without a finite fit
  void search() {
    SquaresProblem problem;
    problem.admit = [&](VectorXd& x) { x = x.cwiseMax(start_ - widest * spread_).cwiseMin(start_ + widest * spread_); };
    problem.residuals = [&](const VectorXd& x, MatrixXd* jacobian) { return residuals(x, jacobian); };
    const Minimum best = least_squares_search(problem, start_, most_refinements);
    if (!std::isfinite(best.value) || !best.at.allFinite())
      throw InputError(targets_.front().data.label, "no finite fit", "inputs and displacements of usual size");
    best_ = best.at;
    rises_ = simulated(best_);
    for (Index i = 0; i < places; ++i)
      if (at_bound(i)) doubtful_ += fmt::format("{}{}", doubtful_.empty() ? "" : ", ", parameters[i].name);
  }

  std::unique_ptr<ChannelModel> model(Index t) const {
    const Target& target = targets_[t];
    const double lag_s = std::exp(best_[places + t]);
    const Line line = fit_line(core::lagged_steps(target.data.time, rises_ * target.row, lag_s), target.data.target,
                               target.data.label);
    auto model = std::make_unique<RotaryUnit>();
    model->logs = best_.head(places);
    model->full = full_;
    model->row = target.row;
    model->roles = roles_;
    model->gain = line.gains[0];
    model->lag_s = lag_s;
    const std::string names = at_bound(places + t) ? doubtful_ + (doubtful_.empty() ? "" : ", ") + "k2" : doubtful_;
    if (!names.empty()) model->doubt = names + " at the bound of the search; the record does not identify it";
    model->intercept = line.intercept;
    model->rms = std::sqrt(line.squares / line.rows);
    return model;
  }

private:
  static constexpr double widest = 4.0;  // spreads from the usual value

  bool at_bound(Index i) const { return std::abs(best_[i] - start_[i]) > (widest - 1e-6) * spread_[i]; }

  MatrixXd simulated(const VectorXd& x) const {
    return simulate_unit(targets_.front().data, roles_, full_, x.head(places), targets_.front().averaged);
  }

  VectorXd residuals_of(const VectorXd& x, const MatrixXd& rises) const {
    std::vector<double> all;
    for (Index t = 0; t < std::ssize(targets_); ++t) {
      const Target& target = targets_[t];
      const VectorXd y = core::lagged_steps(target.data.time, rises * target.row, std::exp(x[places + t]));
      const Line line = fit_line(y, target.data.target, target.data.label);
      const double scale = 1.0 / (noise_share * target.spread * std::sqrt(line.rows));
      for (Index i = 0; i < y.size(); ++i) {
        const double off = target.data.target[i] - line.intercept - line.gains[0] * y[i];
        all.push_back(std::isfinite(off) ? scale * off * std::sqrt(most_unit_blocks) * 0.3 : 0.0);
      }
    }
    const VectorXd prior = (x - start_).cwiseQuotient(spread_);
    all.insert(all.end(), prior.begin(), prior.end());
    return Eigen::Map<const VectorXd>(all.data(), std::ssize(all));
  }

  VectorXd residuals(const VectorXd& x, MatrixXd* jacobian) const {
    const MatrixXd rises = simulated(x);
    const VectorXd at = residuals_of(x, rises);
    if (jacobian) {
      constexpr double step = 1e-3;
      jacobian->resize(at.size(), x.size());
      for (Index k = 0; k < x.size(); ++k) {
        VectorXd moved = x;
        moved[k] += step;
        jacobian->col(k) = (residuals_of(moved, k < places ? simulated(moved) : rises) - at) / step;
      }
    }
    return at;
  }

  const std::vector<Target>& targets_;
  const Roles& roles_;
  const VectorXd& full_;
  VectorXd start_, spread_;
  VectorXd best_;
  MatrixXd rises_;
  std::string doubtful_;
};

/// Roles of the inputs; without a swivel axis among them its letter is in the names of the errors.
Roles roles_of(const std::vector<UnitChannel>& channels) {
  Roles roles = find_roles(channels.front().data.info);
  const bool swivels = roles.s_power >= 0 || roles.s_speed >= 0;
  for (const UnitChannel& channel : channels) {
    if (!swivels && channel.quantity.size() == 3 && (channel.quantity == "B0C" || channel.quantity[2] == 'A'))
      roles.a_c = true;
  }
  return roles;
}

}  // namespace
}  // namespace rotary

std::vector<Eigen::Index> rotary_unit_inputs(const std::vector<InputInfo>& info, const std::string& label) {
  const rotary::Roles roles = rotary::find_roles(info);
  if (roles.c_power < 0 && roles.c_speed < 0) {
    throw core::InputError(label, "no speed or power of a C axis that changes",
                           "a channel such as axis.C.feed_deg_min or C.power_W");
  }
  std::vector<Eigen::Index> used;
  for (const Eigen::Index role : {roles.c_power, roles.c_speed, roles.s_power, roles.s_speed, roles.air, roles.inlet}) {
    if (role >= 0) used.push_back(role);
  }
  std::sort(used.begin(), used.end());
  return used;
}

std::vector<std::unique_ptr<ChannelModel>> fit_rotary_unit(const std::vector<UnitChannel>& channels,
                                                           std::vector<std::string>& left_out) {
  std::vector<std::unique_ptr<ChannelModel>> models(channels.size());
  if (channels.empty()) return models;
  const rotary::Roles roles = rotary::roles_of(channels);
  const TrainingData& first = channels.front().data;
  const Eigen::VectorXd full = rotary::full_speeds(roles, first.info, first.inputs);
  const std::vector<rotary::Target> targets = rotary::find_targets(channels, roles.a_c, left_out);
  if (targets.empty()) return models;
  rotary::UnitFit fit(targets, roles, full);
  fit.search();
  for (Eigen::Index t = 0; t < std::ssize(targets); ++t) models[targets[t].channel] = fit.model(t);
  return models;
}

std::unique_ptr<ChannelModel> make_rotary_unit() { return std::make_unique<rotary::RotaryUnit>(); }

}  // namespace thermotwin::compensation
