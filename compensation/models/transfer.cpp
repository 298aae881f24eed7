// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/transfer.h"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "compensation/measurement/stretch.h"
#include "core/error.h"
#include "core/units.h"

namespace thermotwin::compensation {

namespace {

using core::InputError;
using Eigen::Index;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr std::size_t most_inputs = 4;
constexpr Index highest_order = 3;
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
          const auto [structure, set] = fit_transfer(sub, info, order, radius, data.label, method_);
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
