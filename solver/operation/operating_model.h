// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The affine equation that the full and the reduced model share,
//   E dT/dt + (K0 + sum_j p_j K_j) T = sum_k q_k s_k,   T in K above the reference temperature,
// and the map from channels to its coefficients p (films, contacts on their grids, coolant) and q
// (powers, p times ambient temperatures). Layout says what each j and k is; only machine.toml and
// the joint grids enter, so the same object drives the full model, the reduced one and the online
// compensator. A changed Machine (another film, power, conductance) needs no new matrices.
// Sources: film laws after Gebhardt (2014) Fig. 5.3 and (5.10)-(5.19), see film_laws.h.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine/machine.h"
#include "mesh/machine_mesh.h"
#include "solver/operation/channels.h"
#include "solver/operation/layout.h"
#include "solver/operation/loss_laws.h"

namespace thermotwin::solver {

struct Coefficients {
  Eigen::VectorXd p;          ///< (terms) W/(m^2 K), kg/s or W/K
  Eigen::VectorXd q;          ///< (inputs) W, or p times K
  Eigen::VectorXd occupancy;  ///< (terms) share of time an axis spends at a contact's grid node; else 1
  /// Films with exact radiation. p and q contain it at the mean temperature of the surface; the full model adds the
  /// local difference.
  struct Radiation {
    int film;
    double emissivity, film_coefficient, surroundings_K;
  };
  std::vector<Radiation> radiation;
};

class OperatingModel {
public:
  OperatingModel(const mesh::Machine& machine, const Layout& layout);

  const Channels& channels() const { return channels_; }
  const Layout& layout() const { return layout_; }

  /// @param row        (channels) means over the step, see Channels
  /// @param inlet_K    (coolants) inlet temperatures above the reference, see Chiller
  /// @param readings_K (sensors + observed) temperatures above the reference, means over the step; only the observed
  ///                   ones, after the sensors, are used; empty: laws at their nominal temperatures
  Coefficients coefficients(const Eigen::VectorXd& row, const Eigen::VectorXd& inlet_K,
                            const Eigen::VectorXd& readings_K = {}) const;
  void coefficients(const Eigen::VectorXd& row, const Eigen::VectorXd& inlet_K, const Eigen::VectorXd& readings_K,
                    Coefficients& out) const;  ///< without allocation after the first call
  /// Whether coefficients depend on readings: a step is then iterated.
  bool follows_temperature() const { return follows_temperature_; }
  /// Temperatures of the ambients that guide chillers, (coolants) K above the reference.
  Eigen::VectorXd guide_K(const Eigen::VectorXd& row) const;

  /// Heat of each source, W, after its laws (or measured drive power).
  Eigen::VectorXd source_powers(const Eigen::VectorXd& row) const;
  /// Ambient temperature, K above the reference.
  double ambient_K(int ambient, const Eigen::VectorXd& row) const;
  /// Film coefficient in W/(m^2 K) at this row: constant + radiation, or factor times (law +
  /// radiation); convection at rest and by a disc blend as the root of cubes; times the state.
  double film_coefficient(int film, const Eigen::VectorXd& row, const Eigen::VectorXd& readings_K = {}) const {
    const FilmCoefficients of_film = film_coefficients(film, row, readings_K);
    return of_film.convection + of_film.radiation;
  }
  /// What a film radiates to, K above the reference.
  double surroundings_K(int film, const Eigen::VectorXd& row) const {
    return film_coefficients(film, row, {}).surroundings_K;
  }
  /// Pose in the row's axis positions (SI).
  mesh::Pose pose(const Eigen::VectorXd& row) const;
  const mesh::Machine& machine() const { return machine_; }

private:
  struct FilmCoefficients {
    double convection, radiation;      // W/(m^2 K), with factor and state
    double emissivity;                 // with factor and state
    double ambient_K, surroundings_K;  // above the reference
  };
  FilmCoefficients film_coefficients(std::size_t film, const Eigen::VectorXd& row,
                                     const Eigen::VectorXd& readings_K) const;
  double source_power(std::size_t source, const Eigen::VectorXd& row) const;
  double gradient_K_m(int ambient, const Eigen::VectorXd& row) const;
  double conductance(std::size_t joint, const Eigen::VectorXd& row, const Eigen::VectorXd& readings_K) const;

  void connect_ambients();
  void connect_films();
  void find_first_terms();
  void connect_joints();
  void connect_fluids();
  void connect_sources();

  mesh::Machine machine_;
  Layout layout_;
  Channels channels_;
  std::vector<int> ambient_channels_, ambient_follows_;
  struct FilmChannels {
    int state, speed, table, ambient, surroundings;  // ambient -1: a volume
    int own, volume;                                 // places in readings: its mean, its volume; -1
    double to_rad_s;
    mesh::TableInput table_input;
  };
  FilmChannels channels_of_film(int film) const;
  std::vector<FilmChannels> film_channels_;
  struct ExchangeChannels {
    int state, ambient;
  };  // ambient -1: another volume
  std::vector<std::vector<ExchangeChannels>> exchange_channels_;
  std::vector<int> volume_given_, gradient_channels_;
  bool follows_temperature_ = false;
  int machine_on_;
  Eigen::VectorXd still_film_;      // W/(m^2 K), convection of the air at rest (laws), or the constant
  Eigen::VectorXd radiation_film_;  // W/(m^2 K)
  std::vector<int> film_first_input_, joint_first_term_, joint_ambient_, coolant_on_, source_drive_;
  struct LawChannel {
    int channel;
    mesh::TableInput input;
    double half_speed;
  };  // half_speed 0: the law is not over a speed
  std::vector<std::vector<LawChannel>> law_channels_;
  std::vector<std::vector<LossInput>> loss_inputs_;
  std::vector<double> contact_factor_, clamped_factor_;  // of joints' conductances, by pressure
  std::vector<int> joint_clamped_, joint_reading_;       // joint_reading: place of its mean temperature, -1
};

}  // namespace thermotwin::solver
