// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/transfer.h"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "compensation/measurement/stretch.h"
#include "compensation/models/least_squares.h"
#include "compensation/models/transfer_function.h"
#include "core/error.h"
#include "core/minimum_norm.h"
#include "core/missing.h"
#include "core/units.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr std::size_t most_inputs = 4;
constexpr Index highest_order = 3;
constexpr int thirds = 3;
constexpr Index most_step_values = 400;  ///< about, of a step response
constexpr double most_samples = 4000;    ///< of a grid, where little of a long record may be fitted

/// Differences to the ambient temperature, where it is known.
void relate_to_ambient(const std::vector<InputInfo>& info, Eigen::Ref<RowVectorXd, 0, Eigen::InnerStride<>> row) {
  const Index ambient = ambient_input(info);
  if (ambient < 0) return;
  for (Index i = 0; i < std::ssize(info); ++i) {
    if (info[i].temperature && i != ambient) row[i] -= row[ambient];
  }
}

/// past(k, j) = values(k - j); before the record as at its start.
double past(const VectorXd& values, Index k, Index j) { return values[std::max<Index>(k - j, 0)]; }
/// The same with nothing before the record.
double past_or_nought(const VectorXd& values, Index k, Index j) { return k >= j ? values[k - j] : 0.0; }

/// y + f1 y(-1) + ... = u, before the record settled or at nought
VectorXd filtered_by_poles(const VectorXd& u, const VectorXd& f, bool settled = true) {
  VectorXd y(u.size());
  const double start = settled && u.size() > 0 ? u[0] / (1.0 + f.sum()) : 0.0;
  for (Index k = 0; k < u.size(); ++k) {
    y[k] = u[k];
    for (Index j = 1; j <= f.size(); ++j) y[k] -= f[j - 1] * (k >= j ? y[k - j] : start);
  }
  return y;
}

/// What is chosen by the data.
struct Structure {
  Index order = 1;
  /// The record starts at rest, as calibrations do (documents 001, 002), and is fitted so. Else each input may bring a
  /// free motion of its own; in one short record that takes the place of slow poles, and the prediction, which starts
  /// settled, is far off.
  bool settled = false;
};
constexpr double settled_share = 1.3;  ///< of the free fit's RMS: the record starts at rest

class Identification {
public:
  Identification(const Grid& grid, std::vector<InputInfo> info, const VectorXd& target, const Structure& structure,
                 double radius, const std::string& label)
      : grid_(grid),
        target_(target),
        order_(structure.order),
        starts_(structure.settled ? 0 : structure.order),
        radius_(radius),
        label_(label) {
    set_.step = grid.step;
    set_.info = std::move(info);
    const Index inputs = grid.inputs.cols();
    set_.reference = grid.inputs.colwise().mean().transpose();
    set_.b = MatrixXd::Zero(inputs, order_ + 1);
    set_.f = MatrixXd::Zero(inputs, order_);
    start_ = MatrixXd::Zero(inputs, starts_);
  }

  TransferSet run(TransferMethod method) {
    least_squares_fit(method == TransferMethod::armax ? order_ : 0);
    if (method == TransferMethod::output_error) simulate_fit();
    return set_;
  }
  /// Sum of squares of what the output error fit leaves.
  double left() const { return left_; }

private:
  Index inputs() const { return grid_.inputs.cols(); }

  /// y(k) = -sum a y(k-j) + sum b u(k-j) + sum c e(k-j) + constant
  void least_squares_fit(Index noise) {
    std::vector<Index> rows;
    for (Index k = order_; k < target_.size(); ++k) {
      if (target_.segment(k - order_, order_ + 1).allFinite()) rows.push_back(k);
    }
    const Index unknowns = order_ + inputs() * (order_ + 1) + noise + 1;
    if (std::ssize(rows) < 2 * unknowns) {
      throw InputError(label_, fmt::format("{} samples without gap for {} parameters", rows.size(), unknowns),
                       "at least twice as many");
    }
    VectorXd innovation = VectorXd::Zero(target_.size());
    VectorXd a = VectorXd::Zero(order_);
    MatrixXd b = set_.b;
    double constant = 0.0, least = std::numeric_limits<double>::infinity();
    const int passes = noise > 0 ? 12 : 1;
    for (int pass = 0; pass < passes; ++pass) {
      const Index noise_terms = pass == 0 ? 0 : noise;  // the first pass has no innovations yet
      MatrixXd x(std::ssize(rows), unknowns - noise + noise_terms);
      VectorXd z(x.rows());
      for (Index r = 0; r < x.rows(); ++r) {
        const Index k = rows[r];
        Index column = 0;
        for (Index j = 1; j <= order_; ++j) x(r, column++) = -target_[k - j];
        for (Index i = 0; i < inputs(); ++i) {
          for (Index j = 0; j <= order_; ++j) x(r, column++) = grid_.inputs(k - j, i) - set_.reference[i];
        }
        x(r, column++) = 1.0;
        for (Index j = 1; j <= noise_terms; ++j) x(r, column++) = past(innovation, k, j);
        z[r] = target_[k];
      }
      const VectorXd found = core::minimum_norm_solution(x, z);
      const VectorXd residual = z - x * found;
      innovation.setZero();
      for (Index r = 0; r < x.rows(); ++r) innovation[rows[r]] = residual[r];
      if (!found.allFinite() || (pass > 1 && residual.squaredNorm() > least * (1.0 - 1e-6))) break;
      least = residual.squaredNorm();
      a = found.head(order_);
      for (Index i = 0; i < inputs(); ++i) b.row(i) = found.segment(order_ + i * (order_ + 1), order_ + 1).transpose();
      constant = found[order_ + inputs() * (order_ + 1)];
    }
    VectorXd stable = a;
    const bool moved = stabilise(stable, radius_);
    set_.f = stable.transpose().replicate(inputs(), 1);
    set_.b = b;
    set_.constant = constant / (1.0 + stable.sum());
    if (moved) refit_numerators();
  }

  /// How a machine that does not start settled comes to rest: 1/F of an impulse at the start.
  VectorXd free_motion(const VectorXd& f) const {
    VectorXd impulse = VectorXd::Zero(target_.size());
    impulse[0] = 1.0;
    return filtered_by_poles(impulse, f, false);
  }

  /// Numerators and constant on the simulated output, poles (the same for all inputs) as they are.
  void refit_numerators() {
    const Index n = order_ + 1;
    MatrixXd x(target_.size(), inputs() * n + starts_);
    const VectorXd rest = free_motion(set_.f.row(0).transpose());
    for (Index j = 0; j < starts_; ++j) {
      for (Index k = 0; k < x.rows(); ++k) x(k, inputs() * n + j) = past_or_nought(rest, k, j);
    }
    for (Index i = 0; i < inputs(); ++i) {
      const VectorXd filtered =
          filtered_by_poles(grid_.inputs.col(i).array() - set_.reference[i], set_.f.row(i).transpose());
      for (Index j = 0; j < n; ++j) {
        for (Index k = 0; k < x.rows(); ++k) x(k, i * n + j) = past(filtered, k, j);
      }
    }
    const Line line = fit_ridge(x, target_, 1e-8, label_);
    start_.setZero();
    if (starts_ > 0) start_.row(0) = line.gains.tail(starts_).transpose();
    for (Index i = 0; i < inputs(); ++i) set_.b.row(i) = line.gains.segment(i * n, n).transpose();
    set_.constant = line.intercept;
  }

  /// Parameters of an input: numerator, denominator, start.
  Index width() const { return 2 * order_ + 1 + starts_; }

  VectorXd packed() const {
    VectorXd x(inputs() * width() + 1);
    for (Index i = 0; i < inputs(); ++i) {
      x.segment(i * width(), width()) << set_.b.row(i).transpose(), set_.f.row(i).transpose(),
          start_.row(i).transpose();
    }
    x[x.size() - 1] = set_.constant;
    return x;
  }

  void unpack(const VectorXd& x) {
    for (Index i = 0; i < inputs(); ++i) {
      set_.b.row(i) = x.segment(i * width(), order_ + 1).transpose();
      set_.f.row(i) = x.segment(i * width() + order_ + 1, order_).transpose();
      start_.row(i) = x.segment(i * width() + 2 * order_ + 1, starts_).transpose();
    }
    set_.constant = x[x.size() - 1];
  }

  /// Gradient search on the simulated output from several first poles. A start's free motion is
  /// part of the fit only: a prediction starts settled.
  void simulate_fit() {
    std::vector<Index> rows;
    for (Index k = 0; k < target_.size(); ++k) {
      if (std::isfinite(target_[k])) rows.push_back(k);
    }
    SquaresProblem problem;
    problem.residuals = [&](const VectorXd& x, MatrixXd* jacobian) {
      unpack(x);
      const MatrixXd contributions = simulate(set_, grid_.inputs);
      VectorXd residual = ((contributions.rowwise().sum() - target_).array() + set_.constant).matrix();
      if (jacobian) jacobian->resize(std::ssize(rows), x.size());
      for (Index i = 0; i < inputs(); ++i) {
        const VectorXd f = set_.f.row(i).transpose(), rest = free_motion(f);
        VectorXd free = VectorXd::Zero(rest.size());
        for (Index j = 0; j < starts_; ++j) {
          for (Index k = j; k < free.size(); ++k) free[k] += start_(i, j) * rest[k - j];
        }
        residual += free;
        if (!jacobian) continue;
        const VectorXd du = filtered_by_poles(grid_.inputs.col(i).array() - set_.reference[i], f);
        const VectorXd dy = filtered_by_poles(contributions.col(i), f), dfree = filtered_by_poles(free, f, false);
        for (std::size_t r = 0; r < rows.size(); ++r) {
          const Index k = rows[r], first = i * width();
          const Index row = r;
          for (Index j = 0; j <= order_; ++j) (*jacobian)(row, first + j) = past(du, k, j);
          for (Index j = 1; j <= order_; ++j)
            (*jacobian)(row, first + order_ + j) = -past(dy, k, j) - past_or_nought(dfree, k, j);
          for (Index j = 0; j < starts_; ++j) (*jacobian)(row, first + 2 * order_ + 1 + j) = past_or_nought(rest, k, j);
        }
      }
      if (jacobian) jacobian->rightCols(1).setOnes();
      return VectorXd(residual(rows));
    };
    problem.admit = [&](VectorXd& x) {
      for (Index i = 0; i < inputs(); ++i) {
        VectorXd f = x.segment(i * width() + order_ + 1, order_);
        if (f.allFinite() && stabilise(f, radius_)) x.segment(i * width() + order_ + 1, order_) = f;
      }
    };
    std::vector<VectorXd> starts{packed()};  // ARX's poles
    const double samples = target_.size();
    for (const double share : {0.02, 0.1}) {
      // Real poles, the further ones faster: z - e^(-1/(share samples 4^-j))
      VectorXd f = VectorXd::Zero(order_ + 1);
      f[0] = 1.0;
      for (Index j = 0; j < order_; ++j) {
        const double pole = std::exp(-std::pow(4.0, j) / (share * samples));
        for (Index m = order_; m > 0; --m) f[m] -= std::min(pole, radius_) * f[m - 1];
      }
      set_.f = f.tail(order_).transpose().replicate(inputs(), 1);
      refit_numerators();
      starts.push_back(packed());
    }
    Minimum best;
    best.value = std::numeric_limits<double>::infinity();
    for (const VectorXd& start : starts) {
      const Minimum found = least_squares_search(problem, start, 40);
      if (found.value < best.value) best = found;
    }
    if (!std::isfinite(best.value))
      throw InputError(label_, "no finite output error", "inputs and displacements of usual size");
    unpack(best.at);
    left_ = best.value;
  }

  const Grid& grid_;
  const VectorXd& target_;
  Index order_, starts_;
  double radius_;
  const std::string& label_;
  TransferSet set_;
  MatrixXd start_;  ///< (inputs x starts) numerators of the free motion
  double left_ = 0;
};

/// Simulated error on thirds of the known samples that the fit did not see.
double held_out_error(const Grid& grid, const std::vector<InputInfo>& info, TransferMethod method,
                      const Structure& structure, double radius, const std::string& label) {
  std::vector<Index> known;
  for (Index k = 0; k < grid.target.size(); ++k) {
    if (std::isfinite(grid.target[k])) known.push_back(k);
  }
  const std::size_t n = known.size();
  double squares = 0.0;
  for (std::size_t fold = 0; fold < thirds; ++fold) {
    VectorXd target = grid.target;
    for (std::size_t i = fold * n / thirds; i < (fold + 1) * n / thirds; ++i) target[known[i]] = missing;
    const TransferSet set = Identification(grid, info, target, structure, radius, label).run(method);
    const VectorXd output = simulate(set, grid.inputs).rowwise().sum().array() + set.constant;
    for (std::size_t i = fold * n / thirds; i < (fold + 1) * n / thirds; ++i)
      squares += std::pow(output[known[i]] - grid.target[known[i]], 2);
  }
  return std::isfinite(squares) ? squares / n : std::numeric_limits<double>::infinity();
}

const char* method_name(TransferMethod method) {
  return method == TransferMethod::arx ? "ARX" : method == TransferMethod::armax ? "ARMAX" : "output error";
}

class TransferModel final : public ChannelModel {
public:
  explicit TransferModel(TransferMethod method) : method_(method) {}

  void fit(const TrainingData& whole) override {
    TrainingData data = whole;
    for (Index i = 0; i < data.inputs.rows(); ++i) relate_to_ambient(data.info, data.inputs.row(i));
    all_ = data.info;
    const double span = longest_stretch(data);
    if (!(span > 0.0)) throw InputError(data.label, "no displacement over time", "a record with a duration");
    const double interval = usual_interval(data.time);

    double least = std::numeric_limits<double>::infinity();
    std::string refused;
    std::vector<double> steps{std::max({interval, span / 400.0, data.measured_time() / most_samples})};
    if (const double coarse = span / 130.0; coarse > 1.5 * steps[0]) steps.push_back(coarse);
    for (const double step : steps) {
      const Grid grid = make_grid(data, std::ceil(step / interval - 1e-3) * interval);
      // No pole slower than a third of what was measured: it cannot be told from a ramp.
      const double radius = std::exp(-grid.step / (span / 3.0));
      std::vector<Index> taken;
      const auto part = [&](const std::vector<Index>& chosen) {
        std::pair<Grid, std::vector<InputInfo>> result{{grid.step, grid.inputs(Eigen::all, chosen), grid.target}, {}};
        for (const Index i : chosen) result.second.push_back(all_[i]);
        return result;
      };
      double reached = std::numeric_limits<double>::infinity();
      while (taken.size() < std::min(most_inputs, all_.size())) {
        Index best = -1;
        for (Index i = 0; i < std::ssize(all_); ++i) {
          if (std::find(taken.begin(), taken.end(), i) != taken.end() || !grid.inputs.col(i).allFinite()) continue;
          std::vector<Index> trial = taken;
          trial.push_back(i);
          const auto [sub, info] = part(trial);
          try {
            const double error = held_out_error(sub, info, TransferMethod::arx, {1, false}, radius, data.label);
            if (error < reached * 0.98) {
              reached = error;
              best = i;
            }
          } catch (const InputError& error) {
            refused = error.what();
          }
        }
        if (best < 0) break;
        taken.push_back(best);
      }
      if (taken.empty()) continue;
      const auto [sub, info] = part(taken);
      for (Index order = 1; order <= highest_order; ++order) {
        try {
          const auto [structure, set] = fit_order(sub, info, order, radius, data.label);
          const double error = held_out_error(sub, info, method_, structure, radius, data.label);
          if (error < least * 0.98) {  // a higher order has to earn its parameters
            least = error;
            set_ = set;
            chosen_ = taken;
            held_out_rms_ = std::sqrt(error);
            caution_ =
                set.largest_pole() < radius * (1.0 - 1e-6)
                    ? std::string()
                    : fmt::format(
                          "time constant of {:.4g} s is at the bound of the search; the record does not identify it",
                          span / 3.0);
          }
        } catch (const InputError& error) {
          refused = error.what();
        }
      }
    }
    if (!std::isfinite(least)) {
      if (!refused.empty()) throw InputError(refused);
      throw InputError(data.label, "no order with a finite simulated output", "inputs and displacements of usual size");
    }
  }

  std::string caution() const override { return caution_; }
  std::unique_ptr<RowPredictor> start() const override { return std::make_unique<Predictor>(*this); }

  std::string explain(const std::string& unit) const override {
    std::string text =
        fmt::format("{} order {}, grid {:.4g} s, largest pole {:.5f}, held-out rms {:.3g} {};", method_name(method_),
                    set_.order(), set_.step, set_.largest_pole(), held_out_rms_, unit);
    for (Index i = 0; i < set_.b.rows(); ++i) {
      text += fmt::format(" {}: {:.4g} {} per unit, 95 % after {:.3g} h;", input_name(i), set_.static_gain(i), unit,
                          set_.settling_time(i) / core::units::hour);
    }
    return text + fmt::format(" constant {:.4g} {}", set_.constant, unit);
  }

  std::vector<StepResponse> step_responses() const override {
    std::vector<StepResponse> responses;
    for (Index i = 0; i < set_.b.rows(); ++i) {
      const double settling = set_.settling_time(i);
      const auto samples = static_cast<Index>(2.0 * settling / set_.step) + 10;
      const Index every = std::max<Index>(1, samples / most_step_values);
      const VectorXd values = set_.step_response(i, samples);
      responses.push_back({input_name(i), every * set_.step, values(Eigen::seq(0, Eigen::last, every)),
                           set_.static_gain(i), settling, set_.largest_pole(i)});
    }
    return responses;
  }

  void save(ParameterStore& store) const override {
    store.put("step_s", set_.step);
    store.put("constant", set_.constant);
    store.put("reference", set_.reference);
    store.put("numerators", set_.b);
    store.put("denominators", set_.f);
    store.put("held_out_rms", held_out_rms_);
    VectorXd chosen(std::ssize(chosen_));
    for (std::size_t i = 0; i < chosen_.size(); ++i) chosen[i] = chosen_[i];
    store.put("inputs", chosen);
  }

  void load(const ParameterStore& store, const std::vector<InputInfo>& info) override {
    all_ = info;
    chosen_.clear();
    set_ = {};
    for (const double index : store.vector("inputs")) {
      if (!(index >= 0.0 && index < info.size())) {
        throw InputError(store.place() + " inputs", fmt::format("{}", index), fmt::format("0 to {}", info.size() - 1));
      }
      chosen_.push_back(static_cast<Index>(index));
      set_.info.push_back(info[static_cast<std::size_t>(index)]);
    }
    const auto n = std::ssize(chosen_);
    set_.step = store.number("step_s", 1e-6, 1e9);
    set_.constant = store.number("constant");
    set_.reference = store.vector("reference", n);
    set_.f = store.matrix("denominators", n);
    set_.b = store.matrix("numerators", n, set_.f.cols() + 1);
    held_out_rms_ = store.number("held_out_rms", 0.0);
    if (!(set_.largest_pole() < 1.0)) {
      throw InputError(store.place() + " denominators", fmt::format("a pole of magnitude {}", set_.largest_pole()),
                       "stable poles");
    }
  }

private:
  class Predictor final : public RowPredictor {
  public:
    explicit Predictor(const TransferModel& model) : model_(model), predictor_(make_predictor(model.set_)) {}
    double step(double time, const Eigen::Ref<const RowVectorXd>& inputs) override {
      RowVectorXd row = inputs;
      relate_to_ambient(model_.all_, row);
      return predictor_->step(time, row(model_.chosen_));
    }

  private:
    const TransferModel& model_;
    std::unique_ptr<RowPredictor> predictor_;
  };

  std::pair<Structure, TransferSet> fit_order(const Grid& grid, const std::vector<InputInfo>& info, Index order,
                                              double radius, const std::string& label) const {
    Identification free(grid, info, grid.target, {order, false}, radius, label);
    TransferSet set = free.run(method_);
    if (method_ != TransferMethod::output_error) return {{order, false}, std::move(set)};
    Identification settled(grid, info, grid.target, {order, true}, radius, label);
    TransferSet from_rest = settled.run(method_);
    const bool rests = settled.left() <= settled_share * settled_share * free.left();
    return {{order, rests}, std::move(rests ? from_rest : set)};
  }

  /// Of an input that enters as a difference, what it is a difference to.
  std::string input_name(Index input) const {
    const InputInfo& info = set_.info[input];
    return info.id + (ambient_input(all_) >= 0 && info.temperature && !info.ambient ? " - ambient" : "");
  }

  TransferMethod method_;
  std::vector<InputInfo> all_;
  std::vector<Index> chosen_;
  TransferSet set_;
  double held_out_rms_ = 0;
  std::string caution_;
};

}  // namespace

std::unique_ptr<ChannelModel> make_transfer_model(TransferMethod method) {
  return std::make_unique<TransferModel>(method);
}

}  // namespace thermotwin::compensation
