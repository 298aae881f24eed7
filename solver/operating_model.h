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
#include "solver/chiller.h"

namespace thermotwin::solver {

enum class TermKind { film, contact, coolant_wall, coolant_flow };
struct Term {
  TermKind kind;
  int item = 0;     ///< index into machine.films, .joints or .coolants
  int part = 0;     ///< contact: grid node; coolant_wall: segment; else 0
};

enum class InputKind { film_ambient, contact_ambient, source, coolant_inlet };
struct Input {
  InputKind kind;
  int term = -1;    ///< *_ambient and coolant_inlet: the term whose coefficient multiplies
  int item = 0;     ///< source: index into machine.sources; coolant_inlet: index into coolants
  int place = 0;    ///< source: index into its places
  int node = 0;     ///< source at a joint: grid node
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
};

/// Terms and inputs of the machine on the given grids, in a fixed order (films; joints, each with
/// its nodes; coolants: walls of each segment, then flow).
Layout make_layout(const mesh::Machine& machine, std::vector<JointGrid> grids);

/// Non-negative weights of the grid nodes, sum 1: hat functions at one position, or their mean over
/// an axis that spends its time evenly in [low, high].
Eigen::VectorXd grid_weights(const JointGrid& grid, double low, double high);

struct Coefficients {
  Eigen::VectorXd p;  ///< (terms) W/(m^2 K) or kg/s
  Eigen::VectorXd q;  ///< (inputs) W, or p times K
  Eigen::VectorXd occupancy;  ///< (terms) share of time an axis spends at a contact's grid node; else 1
};

class OperatingModel {
 public:
  OperatingModel(const mesh::Machine& machine, const Layout& layout);

  const Channels& channels() const { return channels_; }

  /// @param row       (channels) means over the step, see Channels
  /// @param inlet_K   (coolants) inlet temperatures above the reference, see Chiller
  Coefficients coefficients(const Eigen::VectorXd& row, const Eigen::VectorXd& inlet_K) const;
  void coefficients(const Eigen::VectorXd& row, const Eigen::VectorXd& inlet_K,
                    Coefficients& out) const;   ///< without allocation after the first call

  /// Heat of each source, W, after its laws (or measured drive power).
  Eigen::VectorXd source_powers(const Eigen::VectorXd& row) const;
  /// Ambient temperature, K above the reference.
  double ambient_K(int ambient, const Eigen::VectorXd& row) const;
  /// Film coefficient in W/(m^2 K) at this row: constant + radiation, or factor times (law +
  /// radiation); convection at rest and by a disc blend as the root of cubes; times the state.
  double film_coefficient(int film, const Eigen::VectorXd& row) const;
  /// Pose in the row's axis positions (SI).
  mesh::Pose pose(const Eigen::VectorXd& row) const;
  const mesh::Machine& machine() const { return machine_; }

 private:
  double source_power(std::size_t source, const Eigen::VectorXd& row) const;

  mesh::Machine machine_;
  Layout layout_;
  Channels channels_;
  struct AxisChannels { int position, feed, low, high; double unit; };
  std::vector<AxisChannels> axis_channels_;       // unit: SI value of one unit of the position
  std::vector<int> ambient_channels_, ambient_follows_;
  struct FilmChannels { int state, speed, ambient; double to_rad_s; };
  std::vector<FilmChannels> film_channels_;
  Eigen::VectorXd still_film_;      // W/(m^2 K), convection of the air at rest (laws), or the constant
  Eigen::VectorXd radiation_film_;  // W/(m^2 K)
  std::vector<int> joint_first_term_, joint_ambient_, coolant_on_, source_drive_;
  struct LawChannel { int channel; bool magnitude; };
  std::vector<std::vector<LawChannel>> law_channels_;
};

}  // namespace thermotwin::solver
