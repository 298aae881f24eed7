// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/three_modules.h"

#include <Eigen/QR>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "compensation/models/lag_bank.h"
#include "compensation/models/temperature_history.h"
#include "compensation/models/whole_programs.h"
#include "core/error.h"
#include "core/missing.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr double edge_K = 1.6;      ///< of the stable mode, (8)
constexpr double uniform_K = 0.25;  ///< a machine whose temperatures differ by less is in its steady state
const std::vector<double> ambient_ridges{1e-8, 1e-6, 1e-4, 1e-2},
    internal_ridges{1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.3, 1.0};
const std::vector<double> element_s{3 * core::units::hour, 12 * core::units::hour};

/// Piecewise linear curve over the baseline; straight on beyond its ends.
struct BaselineCurve {
  VectorXd at, value;
  double operator()(double x) const {
    if (at.size() == 0) return 0.0;
    if (at.size() == 1) return value[0];
    const Index above = std::clamp<Index>(std::upper_bound(at.begin(), at.end(), x) - at.begin(), 1, at.size() - 1);
    const double share = (x - at[above - 1]) / (at[above] - at[above - 1]);
    return value[above - 1] + share * (value[above] - value[above - 1]);
  }
};

/// Offset of a sensor by the surroundings, (1) to (7).
struct SensorOffset {
  int input = 0;             ///< 0 or 1: which of the ambient sensors
  double gain = 0, dip = 0;  ///< a, and b in K
  double operator()(const std::array<double, 2>& ambient) const {
    return gain * ambient[input] + dip * dip_of(ambient[input]);
  }
  static double dip_of(double kelvin) { return 1.0 / (1.0 + std::abs(2.0 * kelvin)) - 1.0; }
};

/// What all modules share. Inputs: temperatures of the machine (and the air).
struct ModuleLayout {
  std::array<Index, 2> ambient{};  ///< inputs; the first guides the modes and is the baseline
  std::vector<Index> internal;     ///< inputs of module 3
  double sigma_s = 0;              ///< of the Gaussian filter; 0: none
  std::vector<double> memories;    ///< s, of module 2
  std::vector<double> lags;        ///< s, of module 3
  bool baseline = true;
  double reference = 0;  ///< of T without module 1
};

struct ModuleRow {
  double baseline = 0;
  RowVectorXd ambient;                ///< features of module 2
  std::array<double, 2> deviation{};  ///< T1 of the ambient sensors
  RowVectorXd above;                  ///< (internal) sensors less the baseline
};

/// Features of one row after the other. @param fixed  baseline at the first reading, as in training
class ModuleFeatures {
public:
  ModuleFeatures(const ModuleLayout& layout, bool fixed)
      : layout_(layout),
        fixed_(fixed),
        memories_(std::vector<InputInfo>(2, InputInfo{}),
                  layout.memories.empty() ? std::vector<double>{0.0} : layout.memories) {}

  static Index ambient_size(const ModuleLayout& layout) { return 16 + 6 * std::ssize(layout.memories); }

  /// @return whether all inputs are there
  bool step(double time, const Eigen::Ref<const RowVectorXd>& inputs, ModuleRow& row) {
    const double first = inputs[layout_.ambient[0]], second = inputs[layout_.ambient[1]];
    bool known = std::isfinite(first) && std::isfinite(second);
    for (const Index i : layout_.internal) known = known && std::isfinite(inputs[i]);
    if (!known) return false;
    histories_[0].add(time, first);
    histories_[1].add(time, second);
    if (!started_) start_ = first;
    started_ = true;
    row.baseline = !layout_.baseline ? layout_.reference : fixed_ ? start_ : histories_[0].mean();
    row.deviation = {first - row.baseline, second - row.baseline};
    std::array<double, 2> smooth = row.deviation;
    for (std::size_t i = 0; layout_.sigma_s > 0.0 && i < 2; ++i)
      smooth[i] = histories_[i].filtered(layout_.sigma_s) - row.baseline;
    RowVectorXd pair(2);
    pair << first, second;
    const MatrixXd past = memories_.step(time, pair);
    row.ambient.resize(ambient_size(layout_));
    Index at = 0;
    const auto put = [&](double value) { row.ambient[at++] = value; };
    const double u = row.deviation[0], b = smooth[0], a = smooth[1];
    const double stable = std::max(0.0, 1.0 - std::pow(u / edge_K, 6));
    const double x = std::clamp(a / edge_K, -2.0, 2.0), y = std::clamp(b / edge_K, -2.0, 2.0);
    for (const double value : {x, y, x * y, std::abs(x), std::abs(y), 1.0}) put(stable * value);
    for (const bool cold : {true, false}) {
      const double share = (u < 0.0) == cold ? 1.0 - stable : 0.0, size = std::abs(b);
      for (const double value : {size, std::sqrt(size), size * std::sqrt(size), a, 1.0}) put(share * value);
    }
    for (std::size_t m = 0; m < layout_.memories.size(); ++m) {
      for (Index i = 0; i < 2; ++i) {
        const double late = past(i, m) - pair[i];
        put(stable * late);
        put(u < 0.0 ? (1.0 - stable) * late : 0.0);
        put(u >= 0.0 ? (1.0 - stable) * late : 0.0);
      }
    }
    row.above.resize(std::ssize(layout_.internal));
    for (std::size_t k = 0; k < layout_.internal.size(); ++k) row.above[k] = inputs[layout_.internal[k]] - row.baseline;
    return true;
  }

private:
  const ModuleLayout& layout_;
  bool fixed_, started_ = false;
  double start_ = 0;
  std::array<TemperatureHistory, 2> histories_;
  LagBank memories_;
};

/// Features of module 3 from the sensors less baseline and offsets.
class InternalFeatures {
public:
  InternalFeatures(const ModuleLayout& layout, const VectorXd& bend)
      : bend_(bend),
        lags_(std::vector<InputInfo>(layout.internal.size(), InputInfo{}),
              layout.lags.empty() ? std::vector<double>{0.0} : layout.lags),
        lagged_(std::ssize(layout.lags)) {}
  static Index size(const ModuleLayout& layout) { return std::ssize(layout.internal) * (2 + std::ssize(layout.lags)); }
  RowVectorXd step(double time, const RowVectorXd& warm) {
    const Index n = warm.size();
    RowVectorXd row(n * (2 + lagged_));
    const MatrixXd& past = lags_.step(time, warm);
    row.head(n) = warm;
    for (Index k = 0; k < n; ++k) row[n + k] = std::max(0.0, warm[k] - bend_[k]);
    for (Index m = 0; m < lagged_; ++m) row.segment((2 + m) * n, n) = past.col(m).transpose();
    return row;
  }

private:
  const VectorXd& bend_;
  LagBank lags_;
  Index lagged_;
};

enum class ProgramKind { baseline, ambient, internal };
struct ModuleProgram {
  Index from, to;  ///< rows [from, to)
  ProgramKind kind;
};

/// Whether the input of a control stands for the machine being on, not for something that it does.
bool is_standby(const InputInfo& info) {
  return info.input == "machine.on" || (info.input.starts_with("coolant.") && info.input.ends_with(".on"));
}

std::vector<ModuleProgram> stretches_of(const TrainingData& data) {
  std::vector<ModuleProgram> stretches;
  Index from = 0;
  for (std::size_t i = 0; i <= data.breaks.size(); i += 2) {
    const Index to = i < data.breaks.size() ? data.breaks[i] : data.time.size();
    bool on = false, works = false;
    for (Index k = 0; k < std::ssize(data.info); ++k) {
      if (data.info[k].temperature) continue;
      const bool any = (data.inputs.col(k).segment(from, to - from).array() > 0.0).any();
      (is_standby(data.info[k]) ? on : works) |= any;
    }
    stretches.push_back({from, to, works ? ProgramKind::internal : on ? ProgramKind::ambient : ProgramKind::baseline});
    if (i < data.breaks.size()) from = data.breaks[i + 1];
  }
  return stretches;
}

/// The two temperatures whose range depends least on the program that runs; first the one that moves less.
std::array<Index, 2> ambient_sensors(const TrainingData& data, const std::vector<Index>& temperatures,
                                     const std::vector<ModuleProgram>& stretches) {
  struct Candidate {
    double spread, moved;
    Index input;
  };
  std::vector<Candidate> candidates;
  for (const Index k : temperatures) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (const ModuleProgram& stretch : stretches) {
      if (stretch.kind != ProgramKind::internal) continue;
      const auto [low, high] = [&] {
        double least = std::numeric_limits<double>::infinity(), most = -least;
        for (const double value : data.inputs.col(k).segment(stretch.from, stretch.to - stretch.from)) {
          if (!std::isfinite(value)) continue;
          least = std::min(least, value);
          most = std::max(most, value);
        }
        return std::pair{least, most};
      }();
      if (!(high >= low)) continue;
      sum += high - low;
      squares += (high - low) * (high - low);
      count += 1.0;
    }
    if (count < 1.0) continue;
    candidates.push_back({squares / count - sum * sum / (count * count), sum / count, k});
  }
  if (candidates.size() < 2) {
    throw InputError(data.label,
                     fmt::format("{} temperature{} of the machine with readings at work", candidates.size(),
                                 candidates.size() == 1 ? "" : "s"),
                     "at least two");
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.spread < b.spread; });
  const bool ordered = candidates[0].moved <= candidates[1].moved;
  return {candidates[ordered ? 0 : 1].input, candidates[ordered ? 1 : 0].input};
}

class ThreeModules final : public ChannelModel {
public:
  explicit ThreeModules(ThreeModulesOptions options) : options_(options) {}

  void fit(const TrainingData& data) override {
    info_ = data.info;
    const std::vector<ModuleProgram> stretches = stretches_of(data);
    choose_sensors(data, stretches);
    fit_baseline(data, stretches);
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

  void save(Archive& archive) const override {
    MatrixXd curve(curve_.at.size(), 2), offsets(std::ssize(offsets_), 3);
    curve << curve_.at, curve_.value;
    for (std::size_t k = 0; k < offsets_.size(); ++k)
      offsets.row(k) << offsets_[k].input, offsets_[k].gain, offsets_[k].dip;
    const auto whole = [](const auto& values) {
      VectorXd numbers(std::ssize(values));
      for (std::size_t i = 0; i < values.size(); ++i) numbers[i] = double(values[i]);
      return numbers;
    };
    archive.put("ambient", whole(layout_.ambient));
    archive.put("internal", whole(layout_.internal));
    archive.put("sigma_s", layout_.sigma_s);
    archive.put("memories_s", whole(layout_.memories));
    archive.put("lags_s", whole(layout_.lags));
    archive.put("baseline", layout_.baseline ? 1.0 : 0.0);
    archive.put("reference_C", layout_.reference);
    archive.put("curve", curve);
    archive.put("offsets", offsets);
    archive.put("bend_K", bend_);
    archive.put("ambient_gains", ambient_.line.gains);
    archive.put("ambient_intercept", ambient_.line.intercept);
    archive.put("internal_gains", internal_.line.gains);
    archive.put("internal_intercept", internal_.line.intercept);
    archive.put("ridge", internal_.ridge);
  }

  void load(const Archive& archive, const std::vector<InputInfo>& info) override {
    info_ = info;
    const auto inputs_of = [&](const char* key, Index size) {
      std::vector<Index> inputs;
      for (const double index : archive.vector(key, size)) {
        if (!(index >= 0.0 && index < info.size())) {
          throw InputError(fmt::format("{} {}", archive.place(), key), fmt::format("{}", index),
                           fmt::format("0 to {}", info.size() - 1));
        }
        inputs.push_back(static_cast<Index>(index));
      }
      return inputs;
    };
    const std::vector<Index> ambient = inputs_of("ambient", 2);
    layout_.ambient = {ambient[0], ambient[1]};
    layout_.internal = inputs_of("internal", -1);
    layout_.sigma_s = archive.number("sigma_s", 0.0, TemperatureHistory::longest_s);
    const auto times_of = [&](const char* key) {
      std::vector<double> times;
      for (const double time : archive.vector(key)) {
        if (!(time > 0.0))
          throw InputError(fmt::format("{} {}", archive.place(), key), fmt::format("{}", time), "above 0");
        times.push_back(time);
      }
      return times;
    };
    layout_.memories = times_of("memories_s");
    layout_.lags = times_of("lags_s");
    layout_.baseline = archive.number("baseline", 0.0, 1.0) > 0.5;
    layout_.reference = archive.number("reference_C");
    const MatrixXd curve = archive.matrix("curve", -1, 2);
    const auto n = std::ssize(layout_.internal);
    const MatrixXd offsets = archive.matrix("offsets", n, 3);
    curve_ = {curve.col(0), curve.col(1)};
    offsets_.clear();
    for (Index k = 0; k < n; ++k) offsets_.push_back({offsets(k, 0) > 0.5 ? 1 : 0, offsets(k, 1), offsets(k, 2)});
    bend_ = archive.vector("bend_K", n);
    ambient_.line.gains = archive.vector("ambient_gains");
    ambient_.line.intercept = archive.number("ambient_intercept");
    const Index of_ambient = ModuleFeatures::ambient_size(layout_), own = ambient_.line.gains.size();
    if (own != 0 && own != of_ambient)
      throw InputError(archive.place() + " ambient_gains", fmt::format("{} values", own),
                       fmt::format("{}", of_ambient));
    internal_.line.gains =
        archive.vector("internal_gains", InternalFeatures::size(layout_) + (own == 0 ? of_ambient : 0));
    internal_.line.intercept = archive.number("internal_intercept");
    internal_.ridge = archive.number("ridge", 0.0);
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

  /// Knots at the steady states of the programs with the machine off.
  void fit_baseline(const TrainingData& data, const std::vector<ModuleProgram>& stretches) {
    curve_ = {};
    if (!options_.baseline) return;
    std::vector<std::pair<double, double>> steady;
    for (const ModuleProgram& stretch : stretches) {
      for (Index i = stretch.from; stretch.kind == ProgramKind::baseline && i < stretch.to; ++i) {
        const double at = data.inputs(i, layout_.ambient[0]);
        bool uniform = std::isfinite(at) && std::isfinite(data.target[i]);
        for (const Index k : layout_.internal) uniform = uniform && std::abs(data.inputs(i, k) - at) < uniform_K;
        if (uniform) steady.emplace_back(at, data.target[i]);
      }
    }
    std::sort(steady.begin(), steady.end());
    std::vector<double> at, value;
    for (std::size_t i = 0; i < steady.size();) {
      constexpr double apart_K = 0.5;
      double sum = 0.0, sum_value = 0.0, count = 0.0;
      const double first = steady[i].first;
      for (; i < steady.size() && steady[i].first - first < apart_K; ++i) {
        sum += steady[i].first;
        sum_value += steady[i].second;
        count += 1.0;
      }
      at.push_back(sum / count);
      value.push_back(sum_value / count);
    }
    if (at.size() < 2) {
      throw InputError(data.label, fmt::format("{} steady temperature with the machine off", at.size()),
                       "at least two, at which all its temperatures lie within 0.25 K");
    }
    curve_ = {Eigen::Map<VectorXd>(at.data(), std::ssize(at)), Eigen::Map<VectorXd>(value.data(), std::ssize(value))};
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
        const VectorXd found = x.completeOrthogonalDecomposition().solve(z);
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
