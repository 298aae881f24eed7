// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/rotary_unit.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "compensation/models/least_squares.h"
#include "core/error.h"
#include "core/first_order_lag.h"
#include "core/missing.h"
#include "core/units.h"
#include "solver/operation/film_laws.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

enum Body : Index { table, c1, c2, swivel, bed, bodies };
using Temperatures = Eigen::Matrix<double, bodies, 1>;
using Conductances = Eigen::Matrix<double, bodies, bodies>;

// Effective lengths in m (Table 5.4) and the expansion of cast iron that the source takes.
constexpr double d1 = 0.300, d2 = 0.240, d3 = 0.082, d4 = 0.153, d5 = 0.063, d6 = 0.121, radius = 0.160;
constexpr double expansion = 12.4e-6, disc_radius = 0.225, plate_m = 0.4;
constexpr double usual_air_C = 20.0;
constexpr Index most_unit_blocks = 700;
constexpr double longest_step_s = 600.0, noise_share = 0.05;
constexpr int most_refinements = 25;

/// Where inputs are found, -1: not measured.
struct Roles {
  Index c_power = -1, c_speed = -1, s_power = -1, s_speed = -1, air = -1, inlet = -1;
  bool a_c = false;  ///< layout A/C
  VectorXd pack() const {
    VectorXd values(7);
    values << c_power, c_speed, s_power, s_speed, air, inlet, a_c ? 1.0 : 0.0;
    return values;
  }
  static Roles unpack(const VectorXd& v) {
    const auto at = v.cast<Index>();
    return {at[0], at[1], at[2], at[3], at[4], at[5], v[6] > 0.5};
  }
};

/// Words of a name, split where it has no letter or digit.
bool has_word(const std::string& name, const std::string& word) {
  std::string part;
  for (const char c : name + ".") {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      part += c;
    } else {
      if (part == word) return true;
      part.clear();
    }
  }
  return false;
}

Roles find_roles(const std::vector<InputInfo>& info) {
  Roles roles;
  const auto take = [](Index& place, std::size_t i) {
    if (place < 0) place = i;
  };
  for (std::size_t i = 0; i < info.size(); ++i) {
    const std::string name = info[i].id + "." + info[i].input;
    const bool of_c = has_word(name, "C") || has_word(name, "c"), of_a = has_word(name, "A"),
               of_b = has_word(name, "B");
    if (info[i].temperature) {
      if (info[i].ambient)
        take(roles.air, i);
      else if (name.find("inlet") != std::string::npos)
        take(roles.inlet, i);
    } else if (info[i].activity && of_c) {
      take(info[i].motion ? roles.c_speed : roles.c_power, i);
    } else if (info[i].activity && (of_a || of_b)) {
      take(info[i].motion ? roles.s_speed : roles.s_power, i);
      roles.a_c = of_a;
    }
  }
  return roles;
}

/// Raw location error as factors of the bodies' temperatures, um or um/m per K; empty: not in the equations.
VectorXd geometry(const std::string& quantity, bool a_c) {
  VectorXd row = VectorXd::Zero(bodies);
  const char* along[] = {a_c ? "X0C" : "Y0C", a_c ? "X0T" : "Y0T", a_c ? "dx" : "dy"};
  const bool hub = std::any_of(std::begin(along), std::end(along), [&](const char* name) { return quantity == name; });
  if (hub) {
    row[c1] = d1;
    row[swivel] = d2;
  } else if (quantity == "Z0T" || quantity == "dz") {
    row[table] = d3;
    row[c1] = 0.5 * d4;
    row[c2] = 0.5 * d5;
  } else if (quantity == "R0T") {
    row[table] = radius;
  } else if (quantity == (a_c ? "B0C" : "A0C") || quantity == (a_c ? "rb" : "ra")) {
    row[c1] = d1 / d6;
    row[c2] = -d1 / d6;
  } else if (a_c && quantity == "Z0A") {
    row[swivel] = 0.5 * d2;
  } else if (a_c && quantity == "A0A") {
    row[swivel] = d2 / d6;
    row[bed] = -d2 / d6;
  } else {
    return {};
  }
  return 1e6 * expansion * row;
}

/// Parameters of the unit as logarithms, with what such units have and how far from it they may be.
struct Parameter {
  const char* name;
  const char* unit;
  double usual, spread;
};
enum Place : Index {
  cap_t,
  cap_c1,
  cap_c2,
  cap_s,
  cap_b,
  g_t1,
  g_12,
  g_1s,
  g_sb,
  films,
  u_c1,
  u_s,
  split,
  loss_c,
  power_c,
  loss_s,
  power_s,
  places
};
constexpr Parameter parameters[places] = {{"capacity table", "J/K", 6e4, 0.7},
                                          {"capacity C body 1", "J/K", 7e4, 0.7},
                                          {"capacity C body 2", "J/K", 7e4, 0.7},
                                          {"capacity swivel body", "J/K", 2e5, 0.7},
                                          {"capacity bed", "J/K", 3e6, 0.7},
                                          {"conductance table to C body 1", "W/K", 40, 0.8},
                                          {"conductance C body 1 to 2", "W/K", 80, 0.8},
                                          {"conductance C body 1 to swivel", "W/K", 80, 0.8},
                                          {"conductance swivel to bed", "W/K", 80, 0.8},
                                          {"films", "of the laws", 1, 0.5},
                                          {"cooling of C body 1", "W/K", 60, 1.0},
                                          {"cooling of the swivel body", "W/K", 60, 1.0},
                                          {"table's heat over that of C body 1", "1", 1, 0.7},
                                          {"loss of C at full speed", "W", 400, 1.0},
                                          {"loss of C rises with speed to the power", "1", 1.3, 0.3},
                                          {"loss of the swivel at full speed", "W", 300, 1.0},
                                          {"loss of the swivel rises with speed to the power", "1", 1.0, 0.3}};
constexpr double areas[bodies] = {0.5, 0.4, 0.4, 1.0, 4.0};  // m2, of the usual unit

VectorXd usual_parameters() {
  VectorXd x(places);
  for (Index i = 0; i < places; ++i) x[i] = std::log(parameters[i].usual);
  return x;
}

/// What holds over an interval.
struct Drive {
  double c_power = 0, s_power = 0, c_speed = 0, s_speed = 0, air = 0, inlet = missing;  // W, share of full speed, degC
  double c_rad_s = 0;
};

/// The unit with its parameters, moved from row to row.
class Unit {
public:
  Unit(const VectorXd& logs, const Roles& roles, const VectorXd& full_speed)
      : p_(logs.array().exp()),
        roles_(roles),
        full_(full_speed) {}

  /// @param row  (inputs) held or mean over the interval, complete
  Drive drive(const Eigen::Ref<const RowVectorXd>& row) const {
    Drive d;
    const auto value = [&](Index role) { return role >= 0 ? row[role] : 0.0; };
    d.air = air(row);
    if (roles_.inlet >= 0) d.inlet = row[roles_.inlet];
    d.c_speed = full_[0] > 0.0 ? std::abs(value(roles_.c_speed)) / full_[0] : 0.0;
    d.s_speed = full_[1] > 0.0 ? std::abs(value(roles_.s_speed)) / full_[1] : 0.0;
    d.c_rad_s = std::abs(value(roles_.c_speed)) * full_[2];
    d.c_power = roles_.c_power >= 0 ? value(roles_.c_power) : p_[loss_c] * std::pow(d.c_speed, p_[power_c]);
    d.s_power = roles_.s_power >= 0 ? value(roles_.s_power) : p_[loss_s] * std::pow(d.s_speed, p_[power_s]);
    return d;
  }

  /// An air that nobody measures, or that stands, is as good as any other constant.
  double air(const Eigen::Ref<const RowVectorXd>& row) const { return roles_.air >= 0 ? row[roles_.air] : usual_air_C; }
  void start(const Eigen::Ref<const RowVectorXd>& row) { temperature_.setConstant(air(row)); }
  const Temperatures& temperature() const { return temperature_; }

  /// Backward Euler: inert bodies, any interval.
  void advance(const Drive& d, double duration) {
    const int steps = std::max(1, static_cast<int>(std::ceil(duration / longest_step_s)));
    // A break of days needs no finer steps than its decay.
    const double h = duration / std::min(steps, 400);
    const double disc = d.c_rad_s > 0.0 ? solver::rotating_disc(d.c_rad_s, disc_radius) : 0.0;
    static constexpr double sees[bodies] = {1.0, 0.3, 0.1, 0.1, 0.0};
    for (int i = 0; i < std::min(steps, 400); ++i) {
      Conductances a = Conductances::Zero();
      Temperatures right;
      const auto connect = [&](Index one, Index other, double g) {
        a(one, one) += g;
        a(other, other) += g;
        a(one, other) -= g;
        a(other, one) -= g;
      };
      connect(table, c1, p_[g_t1]);
      connect(c1, c2, p_[g_12]);
      connect(c1, swivel, p_[g_1s]);
      connect(swivel, bed, p_[g_sb]);
      for (Index b = 0; b < bodies; ++b) {
        const double delta = std::max(0.5, std::abs(temperature_[b] - d.air));
        const double still = solver::free_convection(b == table ? mesh::Orientation::up : mesh::Orientation::vertical,
                                                     plate_m, delta, core::units::zero_C_in_K + d.air);
        const double film = p_[films] * areas[b] * std::max(still, sees[b] * disc);
        a(b, b) += film;
        right[b] = film * d.air;
      }
      const double to_table = p_[split] / (1.0 + p_[split]);
      right[table] += to_table * d.c_power;
      right[c1] += (1.0 - to_table) * d.c_power;
      right[swivel] += d.s_power;
      for (const auto& [body, u] : {std::pair{Index{c1}, p_[u_c1]}, {Index{swivel}, p_[u_s]}}) {
        a(body, body) += u;
        if (std::isfinite(d.inlet))
          right[body] += u * d.inlet;
        else
          a(body, bed) -= u;  // the chiller holds the inlet at the bed's temperature
      }
      for (Index b = 0; b < bodies; ++b) {
        const double inert = p_[cap_t + b] / h;
        a(b, b) += inert;
        right[b] += inert * temperature_[b];
      }
      temperature_ = Eigen::PartialPivLU<Conductances>(a).solve(right);
    }
  }

private:
  VectorXd p_;
  Roles roles_;
  VectorXd full_;  ///< full speeds of C and swivel as given; rad/s of one unit of C's speed
  Temperatures temperature_ = Temperatures::Zero();
};

/// Full speeds and the unit of C's speed; rpm or deg/min by size and name.
VectorXd full_speeds(const Roles& roles, const std::vector<InputInfo>& info, const MatrixXd& inputs) {
  VectorXd full = VectorXd::Zero(3);
  const auto largest = [&](Index role) {
    double most = 0.0;
    for (Index i = 0; role >= 0 && i < inputs.rows(); ++i) {
      if (std::isfinite(inputs(i, role))) most = std::max(most, std::abs(inputs(i, role)));
    }
    return most;
  };
  full[0] = largest(roles.c_speed);
  full[1] = largest(roles.s_speed);
  if (roles.c_speed >= 0) {
    const InputInfo& c = info[roles.c_speed];
    const bool degrees = (c.id + c.input).find("deg") != std::string::npos;
    full[2] = degrees ? core::units::deg_min : core::units::rpm;
  }
  return full;
}

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

  void save(Archive& archive) const override {
    archive.put("parameters", logs);
    archive.put("roles", roles.pack());
    archive.put("full_speeds", full);
    archive.put("geometry", row);
    archive.put("gain", gain);
    archive.put("lag_s", lag_s);
    archive.put("intercept", intercept);
    archive.put("rms", rms);
  }

  void load(const Archive& archive, const std::vector<InputInfo>& info) override {
    logs = archive.vector("parameters", places);
    const VectorXd packed = archive.vector("roles", 7);
    for (Index i = 0; i < 6; ++i) {
      if (!(packed[i] >= -1.0 && packed[i] < info.size()))
        throw InputError(archive.place() + " roles", fmt::format("{}", packed[i]), "places of inputs");
    }
    roles = Roles::unpack(packed);
    full = archive.vector("full_speeds", 3);
    row = archive.vector("geometry", bodies);
    gain = archive.number("gain");
    lag_s = archive.number("lag_s");
    intercept = archive.number("intercept");
    rms = archive.number("rms", 0.0);
    if (!(lag_s >= 0.0) || !(logs.cwiseAbs().maxCoeff() < 50.0)) {
      throw InputError(archive.place() + " lag_s", fmt::format("{}", lag_s),
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

/// Temperatures above the start at each row, (rows x bodies).
MatrixXd simulate(const TrainingData& data, const Roles& roles, const VectorXd& full, const VectorXd& logs,
                  bool averaged) {
  Unit unit(logs, roles, full);
  MatrixXd rises = MatrixXd::Zero(data.time.size(), bodies);
  RowVectorXd held = RowVectorXd::Constant(data.inputs.cols(), missing), next;
  for (Index k = 0; k < held.size(); ++k) {
    const Index first = known_range(data.inputs.col(k)).first;
    held[k] = first >= 0 ? data.inputs(first, k) : 0.0;
  }
  unit.start(held);
  const Temperatures reference = unit.temperature();
  for (Index i = 0; i < data.time.size(); ++i) {
    next = held;
    for (Index k = 0; k < held.size(); ++k) {
      if (std::isfinite(data.inputs(i, k))) next[k] = data.inputs(i, k);
    }
    if (i > 0) {
      const RowVectorXd over = averaged ? RowVectorXd(0.5 * (held + next)) : held;
      unit.advance(unit.drive(over), data.time[i] - data.time[i - 1]);
    }
    rises.row(i) = (unit.temperature() - reference).transpose();
    held = next;
  }
  return rises;
}

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
    return simulate(targets_.front().data, roles_, full_, x.head(places), targets_.front().averaged);
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

std::vector<Index> rotary_unit_inputs(const std::vector<InputInfo>& info, const std::string& label) {
  const Roles roles = find_roles(info);
  if (roles.c_power < 0 && roles.c_speed < 0) {
    throw InputError(label, "no speed or power of a C axis that changes",
                     "a channel such as axis.C.feed_deg_min or C.power_W");
  }
  std::vector<Index> used;
  for (const Index role : {roles.c_power, roles.c_speed, roles.s_power, roles.s_speed, roles.air, roles.inlet}) {
    if (role >= 0) used.push_back(role);
  }
  std::sort(used.begin(), used.end());
  return used;
}

std::vector<std::unique_ptr<ChannelModel>> fit_rotary_unit(const std::vector<UnitChannel>& channels,
                                                           std::vector<std::string>& left_out) {
  std::vector<std::unique_ptr<ChannelModel>> models(channels.size());
  if (channels.empty()) return models;
  const Roles roles = roles_of(channels);
  const TrainingData& first = channels.front().data;
  const VectorXd full = full_speeds(roles, first.info, first.inputs);
  const std::vector<Target> targets = find_targets(channels, roles.a_c, left_out);
  if (targets.empty()) return models;
  UnitFit fit(targets, roles, full);
  fit.search();
  for (Index t = 0; t < std::ssize(targets); ++t) models[targets[t].channel] = fit.model(t);
  return models;
}

std::unique_ptr<ChannelModel> make_rotary_unit() { return std::make_unique<RotaryUnit>(); }

}  // namespace thermotwin::compensation
