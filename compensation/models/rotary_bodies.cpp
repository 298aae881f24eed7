// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/rotary_bodies.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/character.h"
#include "core/units.h"
#include "solver/operation/film_laws.h"

namespace thermotwin::compensation::rotary {
namespace {

using core::missing;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;
using Conductances = Eigen::Matrix<double, bodies, bodies>;

// Effective lengths in m (Table 5.4) and the expansion of cast iron that the source takes.
constexpr double d1 = 0.300, d2 = 0.240, d3 = 0.082, d4 = 0.153, d5 = 0.063, d6 = 0.121, radius = 0.160;
constexpr double expansion = 12.4e-6, disc_radius = 0.225, plate_m = 0.4;
constexpr double usual_air_C = 20.0;
constexpr double longest_step_s = 600.0;
constexpr double areas[bodies] = {0.5, 0.4, 0.4, 1.0, 4.0};  // m2, of the usual unit

/// Words of a name, split where it has no letter or digit.
bool has_word(const std::string& name, const std::string& word) {
  std::string part;
  for (const char c : name + ".") {
    if (core::is_letter_or_digit(c)) {
      part += c;
    } else {
      if (part == word) return true;
      part.clear();
    }
  }
  return false;
}

}  // namespace

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

VectorXd usual_parameters() {
  VectorXd x(places);
  for (Index i = 0; i < places; ++i) x[i] = std::log(parameters[i].usual);
  return x;
}

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

Unit::Unit(const VectorXd& logs, const Roles& roles, const VectorXd& full_speed)
    : p_(logs.array().exp()),
      roles_(roles),
      full_(full_speed) {}

Drive Unit::drive(const Eigen::Ref<const RowVectorXd>& row) const {
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
double Unit::air(const Eigen::Ref<const RowVectorXd>& row) const {
  return roles_.air >= 0 ? row[roles_.air] : usual_air_C;
}

void Unit::start(const Eigen::Ref<const RowVectorXd>& row) { temperature_.setConstant(air(row)); }

void Unit::advance(const Drive& drive, double duration) {
  const int steps = std::max(1, static_cast<int>(std::ceil(duration / longest_step_s)));
  // A break of days needs no finer steps than its decay.
  constexpr int most_steps = 400;
  const double disc = drive.c_rad_s > 0.0 ? solver::rotating_disc(drive.c_rad_s, disc_radius) : 0.0;
  const int taken = std::min(steps, most_steps);
  for (int i = 0; i < taken; ++i) step(drive, disc, duration / taken);
}

void Unit::step(const Drive& d, double disc, double h) {
  static constexpr double sees[bodies] = {1.0, 0.3, 0.1, 0.1, 0.0};
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

MatrixXd simulate_unit(const TrainingData& data, const Roles& roles, const VectorXd& full, const VectorXd& logs,
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

}  // namespace thermotwin::compensation::rotary
