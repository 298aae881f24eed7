// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/phenomenological.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "compensation/measurement/stretch.h"
#include "compensation/models/lag_bank.h"
#include "compensation/models/least_squares.h"
#include "core/error.h"
#include "core/first_order_lag.h"
#include "core/missing.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr double memory_s = 1800.0;        ///< of the mean temperature, for "warming"
constexpr Index most_state_blocks = 4000;  ///< a mean over both states of the axis would be neither
constexpr double least_start =
    0.05;  ///< of the record's start, in the rows that are fitted: less does not tell how large it was
constexpr double near_bound = 1e-3;  ///< ln of a time constant over the bound of its search

/// 1 while the machine moves (or warms up), 0 while it does not.
class Switch {
public:
  Switch(SwitchBy by, std::vector<InputInfo> info)
      : by_(by),
        info_(std::move(info)),
        slow_({{"mean", true, false, false}}, {memory_s}) {}

  int state(double time, const Eigen::Ref<const RowVectorXd>& inputs) {
    if (by_ == SwitchBy::nothing) return 0;
    bool moves = false, powered = false, any_activity = false, any_motion = false;
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < info_.size(); ++i) {
      const double value = inputs[i];
      any_activity = any_activity || info_[i].activity;
      any_motion = any_motion || info_[i].motion;
      powered = powered || (info_[i].activity && value > 0.0);
      moves = moves || (info_[i].motion && value > 0.0);
      if (info_[i].temperature && std::isfinite(value)) {
        sum += value;
        count += 1.0;
      }
    }
    // A drive that holds takes power too: where a speed is known, it tells what moves.
    if (by_ == SwitchBy::motion || any_activity) return (any_motion ? moves : powered) ? 0 : 1;
    if (count == 0.0) return last_;
    const RowVectorXd mean = RowVectorXd::Constant(1, sum / count);
    last_ = mean[0] >= slow_.step(time, mean)(0, 0) ? 0 : 1;
    return last_;
  }

private:
  SwitchBy by_;
  std::vector<InputInfo> info_;
  LagBank slow_;
  int last_ = 0;
};

class Phenomenological final : public ChannelModel {
public:
  explicit Phenomenological(const PhenomenologicalOptions& options) : options_(options) {}

  std::string caution() const override { return caution_; }

  void fit(const TrainingData& whole) override {
    const Blocks blocks = make_blocks(whole, most_state_blocks);
    const TrainingData& data = blocks.data;
    info_ = data.info;
    const double span = longest_stretch(data);
    if (!(span > 0.0))
      throw InputError(data.label, fmt::format("displacements over {} s", span), "a record with a duration");
    reference_ = VectorXd::Zero(data.inputs.cols());
    for (Index k = 0; k < reference_.size(); ++k) {
      const Index known = known_range(data.inputs.col(k)).first;
      if (info_[k].temperature && known >= 0) reference_[k] = data.inputs(known, k);
    }
    std::vector<int> states;
    Switch switcher(options_.switch_by, info_);
    Index others = 0, counted = 0;
    for (Index i = 0; i < data.time.size(); ++i) {
      states.push_back(switcher.state(data.time[i], data.inputs.row(i)));
      others += std::isfinite(data.target[i]) ? states.back() : 0;
      counted += std::isfinite(data.target[i]);
    }
    constexpr Index least_rows = 10;
    if (others < least_rows || counted - others < least_rows) std::fill(states.begin(), states.end(), 0);
    sets_ = others < least_rows || counted - others < least_rows ? 1 : 2;

    const double interval = whole.measured_time() / (data.time.size() - 1);
    const double fastest = std::log(std::min(0.5 * interval, span / 8.0)), slowest = std::log(span / 2.0);
    const auto bounded = [&](const VectorXd& x) {
      return VectorXd(x.cwiseMax(fastest).cwiseMin(slowest).array().exp());
    };
    const auto line = [&](const VectorXd& tau) {
      return fit_line(responses(data, states, tau), data.target, data.label);
    };
    const auto squares = [&](const VectorXd& x) {
      return line(bounded(x)).squares + 1e-9 * (x - x.cwiseMax(fastest).cwiseMin(slowest)).squaredNorm();
    };
    Minimum best;
    best.value = std::numeric_limits<double>::infinity();
    for (const double share : {0.03, 0.2}) {  // of the record: fast and slow first guess
      const VectorXd start = VectorXd::Constant(sets_, std::clamp(std::log(share * span), fastest, slowest));
      const Minimum found = options_.search == Search::simplex
                                ? simplex_search(squares, start, VectorXd::Constant(sets_, 0.7), 80 * sets_, 1e-9)
                                : gradient_search(data, states, start, bounded);
      if (found.value < best.value) best = found;
    }
    if (!std::isfinite(best.value))
      throw InputError(data.label, "no finite fit", "inputs and displacements of usual size");
    tau_ = bounded(best.at);
    const Line found = line(tau_);
    unpack(found);
    rms_ = std::sqrt(found.squares / found.rows);
    caution_.clear();
    for (Index set = 0; set < sets_; ++set) {
      if (const double log = std::log(tau_[set]); log < fastest + near_bound || log > slowest - near_bound) {
        caution_ = fmt::format(
            "time constant of {:.4g} s is at the bound of the search; the record does not identify it", tau_[set]);
      }
    }
  }

  std::unique_ptr<RowPredictor> start() const override { return std::make_unique<Predictor>(*this); }

  std::string explain(const std::string& unit) const override {
    std::string text;
    for (Index set = 0; set < sets_; ++set) {
      text += fmt::format("{}time constant {:.4g} s (p = {:.4g} 1/s),",
                          sets_ == 1 ? ""
                          : set == 0 ? "moving or heating: "
                                     : " standing or cooling: ",
                          tau_[set], -1.0 / tau_[set]);
      for (Index k = 0; k < gains_.cols(); ++k)
        text += fmt::format(" {} {:.4g}", info_[k].id, gains_(set, k) * tau_[set]);
      text += fmt::format(" {} per unit when settled, shift {:.4g} {};", unit, shift_[set] * tau_[set], unit);
    }
    return text + fmt::format(" start {:.4g} {}, rms of the fit {:.3g} {}", initial_, unit, rms_, unit);
  }

  void save(ParameterStore& store) const override {
    store.put("tau_s", tau_);
    store.put("gains", gains_);
    store.put("shift", shift_);
    store.put("reference", reference_);
    store.put("initial", initial_);
    store.put("constant", constant_);
    store.put("rms", rms_);
  }

  void load(const ParameterStore& store, const std::vector<InputInfo>& info) override {
    info_ = info;
    tau_ = store.vector("tau_s");
    sets_ = tau_.size();
    if (sets_ < 1 || sets_ > 2 || !(tau_.array() > 0.0).all())
      throw InputError(store.place() + " tau_s", "not one or two positive time constants", "one or two above 0");
    gains_ = store.matrix("gains", sets_, std::ssize(info));
    shift_ = store.vector("shift", sets_);
    reference_ = store.vector("reference", std::ssize(info));
    initial_ = store.number("initial");
    constant_ = store.number("constant");
    rms_ = store.number("rms", 0.0);
  }

private:
  /// Moves values of the equation over one interval in which inputs and state of the axis hold.
  class Predictor final : public RowPredictor {
  public:
    explicit Predictor(const Phenomenological& model) : model_(model), switch_(model.options_.switch_by, model.info_) {}

    double step(double time, const Eigen::Ref<const RowVectorXd>& inputs) override {
      if (!std::isfinite(last_time_)) {
        y_ = model_.initial_;
      } else {
        const double tau = model_.tau_[state_];
        y_ = core::LagStep(time - last_time_, tau).standing(y_, source_ * tau);
      }
      last_time_ = time;
      if (!inputs.allFinite()) return missing;
      state_ = std::min<Index>(switch_.state(time, inputs), model_.sets_ - 1);
      source_ = model_.gains_.row(state_).dot(inputs - model_.reference_.transpose()) + model_.shift_[state_];
      return y_ + model_.constant_;
    }

  private:
    const Phenomenological& model_;
    Switch switch_;
    Index state_ = 0;
    double y_ = 0, source_ = 0, last_time_ = missing;
  };

  /// Answer of y to each linear parameter: for each set, gains of the inputs and the shift; the start.
  MatrixXd responses(const TrainingData& data, const std::vector<int>& states, const VectorXd& tau) const {
    const Index inputs = data.inputs.cols(), per_set = inputs + 1, n = data.time.size();
    MatrixXd rows = MatrixXd::Zero(n, sets_ * per_set + 1);
    RowVectorXd y = RowVectorXd::Zero(rows.cols()), source = y;
    y[rows.cols() - 1] = 1.0;
    RowVectorXd last = reference_.transpose();
    for (Index i = 0; i < n; ++i) {
      if (i > 0) {
        const double lag = tau[states[i - 1]];
        const core::LagStep step(data.time[i] - data.time[i - 1], lag);
        y = y.binaryExpr(source, [&](double value, double rate) { return step.standing(value, rate * lag); }).eval();
      }
      rows.row(i) = y;
      for (Index k = 0; k < inputs; ++k) {
        if (std::isfinite(data.inputs(i, k))) last[k] = data.inputs(i, k);
      }
      source.setZero();
      const Index first = states[i] * per_set;
      source.segment(first, inputs) = last - reference_.transpose();
      source[first + inputs] = 1.0;
    }
    // A start that has run off before the first fitted row takes no part, since its size would be anything; neither
    // does a shift that both sets have, which then is the constant.
    double start = 0.0;
    for (Index i = 0; i < n; ++i)
      if (std::isfinite(data.target[i])) start = std::max(start, rows(i, rows.cols() - 1));
    if (start < least_start) {
      rows.rightCols(1).setZero();
      rows.col(inputs).setZero();
    }
    return rows;
  }

  Minimum gradient_search(const TrainingData& data, const std::vector<int>& states, const VectorXd& start,
                          const std::function<VectorXd(const VectorXd&)>& bounded) const {
    const auto residuals = [&](const VectorXd& x) {
      const MatrixXd rows = responses(data, states, bounded(x));
      const Line line = fit_line(rows, data.target, data.label);
      VectorXd residual = (rows * line.gains - data.target).array() + line.intercept;
      for (double& value : residual) value = std::isfinite(value) ? value : 0.0;
      return residual;
    };
    SquaresProblem problem;
    problem.residuals = [&](const VectorXd& x, MatrixXd* jacobian) {
      const VectorXd at = residuals(x);
      if (jacobian) {
        jacobian->resize(at.size(), x.size());
        constexpr double step = 1e-4;
        for (Index k = 0; k < x.size(); ++k) {
          VectorXd moved = x;
          moved[k] += step;
          jacobian->col(k) = (residuals(moved) - at) / step;
        }
      }
      return at;
    };
    return least_squares_search(problem, start, 40);
  }

  void unpack(const Line& line) {
    const Index inputs = reference_.size(), per_set = inputs + 1;
    gains_.resize(sets_, inputs);
    shift_.resize(sets_);
    for (Index set = 0; set < sets_; ++set) {
      gains_.row(set) = line.gains.segment(set * per_set, inputs).transpose();
      shift_[set] = line.gains[set * per_set + inputs];
    }
    initial_ = line.gains[sets_ * per_set];
    constant_ = line.intercept;
  }

  PhenomenologicalOptions options_;
  std::vector<InputInfo> info_;
  Index sets_ = 1;
  VectorXd tau_, shift_, reference_;
  MatrixXd gains_;  ///< (sets x inputs) p2, p5
  double initial_ = 0, constant_ = 0, rms_ = 0;
  std::string caution_;
};

}  // namespace

std::unique_ptr<ChannelModel> make_phenomenological(const PhenomenologicalOptions& options) {
  return std::make_unique<Phenomenological>(options);
}

}  // namespace thermotwin::compensation
