// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/three_modules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "compensation/models/baseline_curve.h"
#include "compensation/models/module_features.h"
#include "compensation/models/module_programs.h"
#include "compensation/models/whole_programs.h"
#include "core/error.h"
#include "core/minimum_norm.h"
#include "core/missing.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

const std::vector<double> ambient_ridges{1e-8, 1e-6, 1e-4, 1e-2},
    internal_ridges{1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.3, 1.0};
const std::vector<double> element_s{3 * core::units::hour, 12 * core::units::hour};

/// Offset of a sensor by the surroundings, (1) to (7).
struct SensorOffset {
  int input = 0;             ///< 0 or 1: which of the ambient sensors
  double gain = 0, dip = 0;  ///< a, and b in K
  double operator()(const std::array<double, 2>& ambient) const {
    return gain * ambient[input] + dip * dip_of(ambient[input]);
  }
  static double dip_of(double kelvin) { return 1.0 / (1.0 + std::abs(2.0 * kelvin)) - 1.0; }
};

class ThreeModules final : public ChannelModel {
public:
  explicit ThreeModules(ThreeModulesOptions options) : options_(options) {}

  void fit(const TrainingData& data) override {
    info_ = data.info;
    const std::vector<ModuleProgram> stretches = module_programs(data);
    choose_sensors(data, stretches);
    curve_ = options_.baseline ? fit_baseline(data, stretches, layout_) : BaselineCurve();
    if (options_.together) return fit_together(data, stretches);
    fit_ambient(data, stretches);
    fit_internal(data, stretches);
  }

  std::unique_ptr<RowPredictor> start() const override { return std::make_unique<Predictor>(*this); }

  std::string explain(const std::string& unit) const override {
    const auto name = [&](Index i) { return info_[i].id; };
    std::string text =
        fmt::format("ambient sensors {} (baseline) and {};", name(layout_.ambient[0]), name(layout_.ambient[1]));
    if (curve_.at.size() > 1) {
      const Index last = curve_.at.size() - 1;
      text += fmt::format(" module 1 {:.3g} {}/K;",
                          (curve_.value[last] - curve_.value[0]) / (curve_.at[last] - curve_.at[0]), unit);
    }
    if (ambient_.line.gains.size() > 0) {
      text += fmt::format(" module 2 filter {:.3g} h, held-out rms {:.3g} {};", layout_.sigma_s / core::units::hour,
                          ambient_.held_out_rms, unit);
    }
    text += fmt::format(" module 3 ridge {:g}, held-out rms {:.3g} {};", internal_.ridge, internal_.held_out_rms, unit);
    for (std::size_t k = 0; k < layout_.internal.size(); ++k)
      text +=
          fmt::format(" {} {:.3g} {}/K;", name(layout_.internal[k]), internal_.line.gains[first_internal() + k], unit);
    return text + fmt::format(" intercept {:.4g} {}", internal_.line.intercept, unit);
  }

  void save(ParameterStore& store) const override {
    MatrixXd curve(curve_.at.size(), 2), offsets(std::ssize(offsets_), 3);
    curve << curve_.at, curve_.value;
    for (std::size_t k = 0; k < offsets_.size(); ++k)
      offsets.row(k) << offsets_[k].input, offsets_[k].gain, offsets_[k].dip;
    const auto whole = [](const auto& values) {
      VectorXd numbers(std::ssize(values));
      for (std::size_t i = 0; i < values.size(); ++i) numbers[i] = double(values[i]);
      return numbers;
    };
    store.put("ambient", whole(layout_.ambient));
    store.put("internal", whole(layout_.internal));
    store.put("sigma_s", layout_.sigma_s);
    store.put("memories_s", whole(layout_.memories));
    store.put("lags_s", whole(layout_.lags));
    store.put("baseline", layout_.baseline ? 1.0 : 0.0);
    store.put("reference_C", layout_.reference);
    store.put("curve", curve);
    store.put("offsets", offsets);
    store.put("bend_K", bend_);
    store.put("ambient_gains", ambient_.line.gains);
    store.put("ambient_intercept", ambient_.line.intercept);
    store.put("internal_gains", internal_.line.gains);
    store.put("internal_intercept", internal_.line.intercept);
    store.put("ridge", internal_.ridge);
  }

  void load(const ParameterStore& store, const std::vector<InputInfo>& info) override {
    info_ = info;
    const auto inputs_of = [&](const char* key, Index size) {
      std::vector<Index> inputs;
      for (const double index : store.vector(key, size)) {
        if (!(index >= 0.0 && index < info.size())) {
          throw InputError(fmt::format("{} {}", store.place(), key), fmt::format("{}", index),
                           fmt::format("0 to {}", info.size() - 1));
        }
        inputs.push_back(static_cast<Index>(index));
      }
      return inputs;
    };
    const std::vector<Index> ambient = inputs_of("ambient", 2);
    layout_.ambient = {ambient[0], ambient[1]};
    layout_.internal = inputs_of("internal", -1);
    layout_.sigma_s = store.number("sigma_s", 0.0, TemperatureHistory::longest_s);
    const auto times_of = [&](const char* key) {
      std::vector<double> times;
      for (const double time : store.vector(key)) {
        if (!(time > 0.0))
          throw InputError(fmt::format("{} {}", store.place(), key), fmt::format("{}", time), "above 0");
        times.push_back(time);
      }
      return times;
    };
    layout_.memories = times_of("memories_s");
    layout_.lags = times_of("lags_s");
    layout_.baseline = store.number("baseline", 0.0, 1.0) > 0.5;
    layout_.reference = store.number("reference_C");
    const MatrixXd curve = store.matrix("curve", -1, 2);
    const auto n = std::ssize(layout_.internal);
    const MatrixXd offsets = store.matrix("offsets", n, 3);
    curve_ = {curve.col(0), curve.col(1)};
    offsets_.clear();
    for (Index k = 0; k < n; ++k) offsets_.push_back({offsets(k, 0) > 0.5 ? 1 : 0, offsets(k, 1), offsets(k, 2)});
    bend_ = store.vector("bend_K", n);
    ambient_.line.gains = store.vector("ambient_gains");
    ambient_.line.intercept = store.number("ambient_intercept");
    const Index of_ambient = ModuleFeatures::ambient_size(layout_), own = ambient_.line.gains.size();
    if (own != 0 && own != of_ambient)
      throw InputError(store.place() + " ambient_gains", fmt::format("{} values", own), fmt::format("{}", of_ambient));
    internal_.line.gains =
        store.vector("internal_gains", InternalFeatures::size(layout_) + (own == 0 ? of_ambient : 0));
    internal_.line.intercept = store.number("internal_intercept");
    internal_.ridge = store.number("ridge", 0.0);
  }

private:
  class Predictor final : public RowPredictor {
  public:
    explicit Predictor(const ThreeModules& model)
        : model_(model),
          modules_(model.layout_, false),
          internal_(model.layout_, model.bend_) {}
    double step(double time, const Eigen::Ref<const RowVectorXd>& inputs) override {
      if (!modules_.step(time, inputs, row_)) return core::missing;
      const RowVectorXd warm = model_.less_offsets(row_);
      return model_.predicted(row_, internal_.step(time, warm));
    }

  private:
    const ThreeModules& model_;
    ModuleFeatures modules_;
    InternalFeatures internal_;
    ModuleRow row_;
  };

  Index first_internal() const { return ambient_.line.gains.size() > 0 ? 0 : ModuleFeatures::ambient_size(layout_); }

  RowVectorXd less_offsets(const ModuleRow& row) const {
    RowVectorXd warm = row.above;
    for (Index k = 0; k < warm.size(); ++k) warm[k] -= offsets_[k](row.deviation);
    return warm;
  }

  double predicted(const ModuleRow& row, const RowVectorXd& internal) const {
    double sum = curve_(row.baseline) + internal_.line.intercept;
    const Index first = first_internal();
    if (first > 0)
      return sum + row.ambient.dot(internal_.line.gains.head(first)) +
             internal.dot(internal_.line.gains.tail(internal.size()));
    sum += ambient_.line.intercept + row.ambient.dot(ambient_.line.gains);
    return sum + internal.dot(internal_.line.gains);
  }

  void choose_sensors(const TrainingData& data, const std::vector<ModuleProgram>& stretches) {
    const auto count_of = [&](ProgramKind kind) {
      return std::count_if(stretches.begin(), stretches.end(), [&](const ModuleProgram& s) { return s.kind == kind; });
    };
    const auto off = count_of(ProgramKind::baseline), on = count_of(ProgramKind::ambient),
               works = count_of(ProgramKind::internal);
    if (on == 0 || works == 0 || (off == 0 && options_.baseline)) {
      throw InputError(
          data.label,
          fmt::format("training programs: {} with the machine off, {} with it on and nothing else, {} at "
                      "work",
                      off, on, works),
          "at least one of each; machine.on tells the first two apart, speeds, powers and states the last");
    }
    std::vector<Index> temperatures;
    for (Index k = 0; k < std::ssize(data.info); ++k) {
      if (data.info[k].temperature && !data.info[k].ambient) temperatures.push_back(k);
    }
    if (temperatures.size() < 3)
      throw InputError(data.label, fmt::format("{} temperatures of the machine", temperatures.size()),
                       "at least three");
    layout_ = {};
    layout_.ambient = ambient_sensors(data, temperatures, stretches);
    for (const Index k : temperatures) {
      if (k != layout_.ambient[0] && k != layout_.ambient[1]) layout_.internal.push_back(k);
    }
    if (!options_.bed_sensors) {
      const Index air = ambient_input(data.info);
      if (air < 0) throw InputError(data.label, "no temperature of the air", "a channel with input = \"air.T_C\"");
      layout_.ambient = {air, air};
    }
    layout_.baseline = options_.baseline;
    if (options_.delays) layout_.memories = element_s;
    double sum = 0.0, count = 0.0;
    for (const ModuleProgram& stretch : stretches) {
      if (stretch.kind != ProgramKind::ambient || !std::isfinite(data.inputs(stretch.from, layout_.ambient[0])))
        continue;
      sum += data.inputs(stretch.from, layout_.ambient[0]);
      count += 1.0;
    }
    layout_.reference = count > 0.0 ? sum / count : 0.0;
  }

  /// Rows of a stretch with the baseline at its start.
  template <class Put>
  void walk(const TrainingData& data, const ModuleProgram& stretch, const Put& put) const {
    ModuleFeatures features(layout_, true);
    ModuleRow row;
    for (Index i = stretch.from; i < stretch.to; ++i) {
      if (features.step(data.time[i], data.inputs.row(i), row)) put(i, row);
    }
  }

  std::vector<ProgramRows> ambient_rows(const TrainingData& data, const std::vector<ModuleProgram>& stretches) const {
    std::vector<ProgramRows> programs;
    for (const ModuleProgram& stretch : stretches) {
      if (stretch.kind != ProgramKind::ambient) continue;
      ProgramRows rows{
          MatrixXd::Constant(stretch.to - stretch.from, ModuleFeatures::ambient_size(layout_), core::missing),
          VectorXd::Constant(stretch.to - stretch.from, core::missing)};
      walk(data, stretch, [&](Index i, const ModuleRow& row) {
        rows.features.row(i - stretch.from) = row.ambient;
        rows.target[i - stretch.from] = data.target[i] - curve_(row.baseline);
      });
      programs.push_back(std::move(rows));
    }
    return programs;
  }

  void fit_ambient(const TrainingData& data, const std::vector<ModuleProgram>& stretches) {
    ambient_.held_out_rms = std::numeric_limits<double>::infinity();
    double best_sigma = 0.0;
    for (const double sigma : options_.delays ? std::vector<double>{0.0, core::units::hour, 3 * core::units::hour}
                                              : std::vector<double>{0.0}) {
      layout_.sigma_s = sigma;
      const ProgramLine found = fit_on_programs(ambient_rows(data, stretches), ambient_ridges, data.label);
      if (!(found.held_out_rms < ambient_.held_out_rms)) continue;
      ambient_ = found;
      best_sigma = sigma;
    }
    layout_.sigma_s = best_sigma;
    fit_offsets(data, stretches);
  }

  /// Offsets of the internal sensors on the programs of module 2, from the better of the two ambient sensors.
  void fit_offsets(const TrainingData& data, const std::vector<ModuleProgram>& stretches) {
    offsets_.assign(layout_.internal.size(), {});
    std::vector<std::array<double, 2>> deviations;
    std::vector<RowVectorXd> above;
    for (const ModuleProgram& stretch : stretches) {
      if (stretch.kind != ProgramKind::ambient) continue;
      walk(data, stretch, [&](Index, const ModuleRow& row) {
        deviations.push_back(row.deviation);
        above.push_back(row.above);
      });
    }
    const auto n = std::ssize(deviations);
    for (std::size_t k = 0; k < offsets_.size(); ++k) {
      double least = std::numeric_limits<double>::infinity();
      for (const int input : {0, 1}) {
        MatrixXd x(n, 2);
        VectorXd z(n);
        for (Index i = 0; i < n; ++i) {
          x.row(i) << deviations[i][input], SensorOffset::dip_of(deviations[i][input]);
          z[i] = above[i][k];
        }
        const VectorXd found = core::minimum_norm_solution(x, z);
        const double left = (z - x * found).squaredNorm();
        if (!(left < least)) continue;
        least = left;
        offsets_[k] = {input, found[0], found[1]};
      }
    }
  }

  /// Half of the largest temperature of each internal sensor in the programs at work.
  void choose_bends(const TrainingData& data, const std::vector<ModuleProgram>& stretches) {
    bend_ = VectorXd::Zero(std::ssize(layout_.internal));
    for (const ModuleProgram& stretch : stretches) {
      if (stretch.kind != ProgramKind::internal) continue;
      walk(data, stretch,
           [&](Index, const ModuleRow& row) { bend_ = bend_.cwiseMax(0.5 * less_offsets(row).transpose()); });
    }
  }

  std::vector<std::vector<double>> lag_choices() const {
    if (!options_.delays) return {{}};
    return {{3600.0}, {1800.0, 7200.0}, {1800.0, 7200.0, 21600.0}};
  }

  void fit_internal(const TrainingData& data, const std::vector<ModuleProgram>& stretches) {
    choose_bends(data, stretches);
    internal_.held_out_rms = std::numeric_limits<double>::infinity();
    std::vector<double> best_lags;
    for (const std::vector<double>& lags : lag_choices()) {
      layout_.lags = lags;
      std::vector<ProgramRows> programs;
      for (const ModuleProgram& stretch : stretches) {
        if (stretch.kind != ProgramKind::internal) continue;
        const Index rows = stretch.to - stretch.from;
        ProgramRows& program =
            programs.emplace_back(ProgramRows{MatrixXd::Constant(rows, InternalFeatures::size(layout_), core::missing),
                                              VectorXd::Constant(rows, core::missing)});
        InternalFeatures features(layout_, bend_);
        walk(data, stretch, [&](Index i, const ModuleRow& row) {
          program.features.row(i - stretch.from) = features.step(data.time[i], less_offsets(row));
          program.target[i - stretch.from] =
              data.target[i] - curve_(row.baseline) - ambient_.line.intercept - row.ambient.dot(ambient_.line.gains);
        });
      }
      const ProgramLine found = fit_on_programs(programs, internal_ridges, data.label);
      if (!(found.held_out_rms < internal_.held_out_rms)) continue;
      internal_ = found;
      best_lags = lags;
    }
    layout_.lags = best_lags;
  }

  /// The features of modules 2 and 3 in one fit over the programs of both; module 1 too is then only an input.
  void fit_together(const TrainingData& data, const std::vector<ModuleProgram>& stretches) {
    ambient_ = {};
    offsets_.assign(layout_.internal.size(), {});
    layout_.lags = lag_choices().size() > 1 ? lag_choices()[1] : lag_choices()[0];
    choose_bends(data, stretches);
    std::vector<ProgramRows> programs;
    const Index of_ambient = ModuleFeatures::ambient_size(layout_), of_internal = InternalFeatures::size(layout_);
    for (const ModuleProgram& stretch : stretches) {
      if (stretch.kind == ProgramKind::baseline) continue;
      const Index rows = stretch.to - stretch.from;
      ProgramRows& program = programs.emplace_back(ProgramRows{
          MatrixXd::Constant(rows, of_ambient + of_internal, core::missing), VectorXd::Constant(rows, core::missing)});
      InternalFeatures features(layout_, bend_);
      walk(data, stretch, [&](Index i, const ModuleRow& row) {
        program.features.row(i - stretch.from) << row.ambient, features.step(data.time[i], row.above);
        program.target[i - stretch.from] = data.target[i] - curve_(row.baseline);
      });
    }
    internal_ = fit_on_programs(programs, internal_ridges, data.label);
  }

  ThreeModulesOptions options_;
  std::vector<InputInfo> info_;
  ModuleLayout layout_;
  BaselineCurve curve_;                ///< module 1
  ProgramLine ambient_;                ///< module 2; no gains: together with module 3
  std::vector<SensorOffset> offsets_;  ///< (internal)
  VectorXd bend_;                      ///< (internal) K
  ProgramLine internal_;               ///< module 3
};

}  // namespace

std::unique_ptr<ChannelModel> make_three_modules(ThreeModulesOptions options) {
  return std::make_unique<ThreeModules>(options);
}

}  // namespace thermotwin::compensation
