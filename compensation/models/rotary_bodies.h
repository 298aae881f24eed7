// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The bodies of a rotary and swivel unit with their heat balances (equations: compensation/models/rotary_unit.h), and
// where a record tells what drives them.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/dataset.h"
#include "core/missing.h"

namespace thermotwin::compensation::rotary {

/// Bodies of the unit.
enum Body : Eigen::Index { table, c1, c2, swivel, bed, bodies };
using Temperatures = Eigen::Matrix<double, bodies, 1>;

/// Where inputs are found, -1: not measured.
struct Roles {
  Eigen::Index c_power = -1, c_speed = -1, s_power = -1, s_speed = -1, air = -1, inlet = -1;
  bool a_c = false;  ///< layout A/C
  Eigen::VectorXd pack() const {
    Eigen::VectorXd values(7);
    values << c_power, c_speed, s_power, s_speed, air, inlet, a_c ? 1.0 : 0.0;
    return values;
  }
  static Roles unpack(const Eigen::VectorXd& v) {
    const auto at = v.cast<Eigen::Index>();
    return {at[0], at[1], at[2], at[3], at[4], at[5], v[6] > 0.5};
  }
};

Roles find_roles(const std::vector<InputInfo>& info);

/// (bodies) raw location error as factors of their temperatures, um or um/m per K; empty: not in the equations.
/// @param quantity  Y0C, Z0T ... (rotary_unit.h)  @param a_c  layout A/C, else B/C
Eigen::VectorXd geometry(const std::string& quantity, bool a_c);

/// Parameters of the unit as logarithms, with what such units have and how far from it they may be.
struct Parameter {
  const char* name;
  const char* unit;
  double usual, spread;
};
enum Place : Eigen::Index {
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
inline constexpr Parameter parameters[places] = {{"capacity table", "J/K", 6e4, 0.7},
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

/// (places) logarithms of the usual parameters
Eigen::VectorXd usual_parameters();

/// What holds over an interval.
struct Drive {
  double c_power = 0, s_power = 0, c_speed = 0, s_speed = 0, air = 0,
         inlet = core::missing;  // W, share of full speed, degC
  double c_rad_s = 0;
};

/// (3) full speeds of C and the swivel axis as given, and rad/s of one unit of C's speed; rpm or deg/min by its name.
Eigen::VectorXd full_speeds(const Roles& roles, const std::vector<InputInfo>& info, const Eigen::MatrixXd& inputs);

/// The unit with its parameters, moved from row to row.
class Unit {
public:
  /// @param logs  (places)  @param full_speed  of full_speeds
  Unit(const Eigen::VectorXd& logs, const Roles& roles, const Eigen::VectorXd& full_speed);

  /// @param row  (inputs) held or mean over the interval, complete
  Drive drive(const Eigen::Ref<const Eigen::RowVectorXd>& row) const;
  /// All bodies take on the temperature of the air.
  void start(const Eigen::Ref<const Eigen::RowVectorXd>& row);
  const Temperatures& temperature() const { return temperature_; }  ///< degC

  /// Backward Euler: inert bodies, any interval. @param duration  s
  void advance(const Drive& drive, double duration);

private:
  double air(const Eigen::Ref<const Eigen::RowVectorXd>& row) const;
  void step(const Drive& drive, double disc, double duration);

  Eigen::VectorXd p_;
  Roles roles_;
  Eigen::VectorXd full_;
  Temperatures temperature_ = Temperatures::Zero();
};

/// (rows x bodies) temperatures above the start. @param averaged  inputs are linear between rows, else held
Eigen::MatrixXd simulate_unit(const TrainingData& data, const Roles& roles, const Eigen::VectorXd& full,
                              const Eigen::VectorXd& logs, bool averaged);

}  // namespace thermotwin::compensation::rotary
