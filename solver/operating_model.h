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

#include "mesh/machine.h"
#include "mesh/machine_mesh.h"
#include "solver/channels.h"
#include "solver/loss_laws.h"

namespace thermotwin::solver {

enum class TermKind { film, contact, coolant_wall, coolant_flow, volume_exchange, volume_given };
struct Term {
  TermKind kind;
  int item = 0;     ///< index into machine.films, .joints, .coolants or .volumes
  int part = 0;     ///< contact: grid node; coolant_wall: segment; volume_exchange: exchange; else 0
};

enum class InputKind { film_ambient, contact_ambient, source, coolant_inlet, film_gradient, volume_ambient, volume_given };
struct Input {
  InputKind kind;
  int term = -1;    ///< all but source: the term whose coefficient multiplies
  int item = 0;     ///< index into the machine's films, joints, sources, coolants or volumes
  int place = 0;    ///< source: index into its places; volume_ambient: exchange
  int node = 0;     ///< source at a joint: grid node
};

/// A temperature that coefficients or chillers follow: mean over a film's surfaces, over both sides
/// of a joint where it touches, mixed return of a coolant, a volume.
enum class ObservedKind { film, joint, coolant_return, volume };
struct Observed {
  ObservedKind kind;
  int item = 0;
};

/// Axis positions where a joint's matrices are stored, m or rad; {0} for a joint that stands.
struct JointGrid {
  int axis = -1;                    ///< index into machine.axes
  bool periodic = false;            ///< endless rotary axis: the last node precedes the first
  std::vector<double> positions;    ///< rising
};

struct Layout {
  std::vector<JointGrid> grids;     ///< one per machine.joints
  std::vector<Term> terms;
  std::vector<Input> inputs;
  std::vector<Observed> observed;   ///< only what the machine needs

  int observed_index(ObservedKind kind, int item) const;  ///< -1 if it is not there
};

/// Terms and inputs of the machine on the given grids, in a fixed order (films; joints, each with
/// its nodes; coolants: walls of each segment, then flow).
Layout make_layout(const mesh::Machine& machine, std::vector<JointGrid> grids);

/// Non-negative weights of the grid nodes, sum 1: hat functions at one position, or their mean over
/// an axis that spends its time evenly in [low, high].
Eigen::VectorXd grid_weights(const JointGrid& grid, double low, double high);

struct Coefficients {
  Eigen::VectorXd p;  ///< (terms) W/(m^2 K), kg/s or W/K
  Eigen::VectorXd q;  ///< (inputs) W, or p times K
  Eigen::VectorXd occupancy;  ///< (terms) share of time an axis spends at a contact's grid node; else 1
  /// Films that radiate by fourth powers, as the surface's mean temperature has them in p and q: the
  /// full model adds what differs from place to place.
  struct Radiation { int film; double emissivity, film_coefficient, surroundings_K; };
  std::vector<Radiation> radiation;
};

class OperatingModel {
 public:
  OperatingModel(const mesh::Machine& machine, const Layout& layout);

  const Channels& channels() const { return channels_; }
  const Layout& layout() const { return layout_; }

  /// @param row        (channels) means over the step, see Channels
  /// @param inlet_K    (coolants) inlet temperatures above the reference, see Chiller
  /// @param readings_K (sensors + observed) temperatures, means over the step, of which what stands
  ///                   behind the sensors is used; empty: laws at their nominal temperatures
  Coefficients coefficients(const Eigen::VectorXd& row, const Eigen::VectorXd& inlet_K,
                            const Eigen::VectorXd& readings_K = {}) const;
  void coefficients(const Eigen::VectorXd& row, const Eigen::VectorXd& inlet_K, const Eigen::VectorXd& readings_K,
                    Coefficients& out) const;   ///< without allocation after the first call
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
    const FilmParts parts = film_parts(static_cast<std::size_t>(film), row, readings_K);
    return parts.convection + parts.radiation;
  }
  /// What a film radiates to, K above the reference.
  double surroundings_K(int film, const Eigen::VectorXd& row) const { return film_parts(static_cast<std::size_t>(film), row, {}).surroundings_K; }
  /// Pose in the row's axis positions (SI).
  mesh::Pose pose(const Eigen::VectorXd& row) const;
  const mesh::Machine& machine() const { return machine_; }

 private:
  struct FilmParts {
    double convection, radiation;      // W/(m^2 K), with factor and state
    double emissivity;                 // with factor and state
    double ambient_K, surroundings_K;  // above the reference
  };
  FilmParts film_parts(std::size_t film, const Eigen::VectorXd& row, const Eigen::VectorXd& readings_K) const;
  double source_power(std::size_t source, const Eigen::VectorXd& row) const;
  double gradient_K_m(int ambient, const Eigen::VectorXd& row) const;
  double conductance(std::size_t joint, const Eigen::VectorXd& row, const Eigen::VectorXd& readings_K) const;

  mesh::Machine machine_;
  Layout layout_;
  Channels channels_;
  struct AxisChannels { int position, feed, low, high; double unit; };
  std::vector<AxisChannels> axis_channels_;       // unit: SI value of one unit of the position
  std::vector<int> ambient_channels_, ambient_follows_;
  struct FilmChannels {
    int state, speed, table, ambient, surroundings;  // ambient -1: a volume
    int own, volume;                                 // places in readings: its mean, its volume; -1
    double to_rad_s;
  };
  std::vector<FilmChannels> film_channels_;
  struct ExchangeChannels { int state, ambient; };   // ambient -1: another volume
  std::vector<std::vector<ExchangeChannels>> exchange_channels_;
  std::vector<int> volume_given_, gradient_channels_;
  bool follows_temperature_ = false;
  int machine_on_ = -1;
  Eigen::VectorXd still_film_;      // W/(m^2 K), convection of the air at rest (laws), or the constant
  Eigen::VectorXd radiation_film_;  // W/(m^2 K)
  std::vector<int> film_first_input_, joint_first_term_, joint_ambient_, coolant_on_, source_drive_;
  struct LawChannel { int channel; bool magnitude; double half_speed; };  // half_speed 0: the law is not over a speed
  std::vector<std::vector<LawChannel>> law_channels_;
  std::vector<std::vector<LossInput>> loss_inputs_;
  std::vector<double> contact_factor_, clamped_factor_;  // of joints' conductances, by pressure
  std::vector<int> joint_clamped_, joint_reading_;       // joint_reading: place of its mean temperature, -1
};

}  // namespace thermotwin::solver
