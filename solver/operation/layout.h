// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the terms and inputs of the affine equation are, of the full and the reduced model alike.

#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::solver {

enum class TermKind { film, contact, coolant_wall, coolant_flow, volume_exchange, volume_given };

struct Term {
  TermKind kind;
  int item = 0;  ///< index into machine.films, .joints, .coolants or .volumes
  int part = 0;  ///< contact: grid node; coolant_wall: segment; volume_exchange: exchange; else 0
};

enum class InputKind {
  film_ambient,
  contact_ambient,
  source,
  coolant_inlet,
  film_gradient,
  volume_ambient,
  volume_given
};

struct Input {
  InputKind kind;
  int term = -1;  ///< all but source: the term whose coefficient multiplies
  int item = 0;   ///< index into the machine's films, joints, sources, coolants or volumes
  int place = 0;  ///< source: index into its places; volume_ambient: exchange
  int node = 0;   ///< source at a joint: grid node
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
  int axis = -1;                  ///< index into machine.axes
  bool periodic = false;          ///< endless rotary axis: the last node precedes the first
  std::vector<double> positions;  ///< rising
};

struct Layout {
  std::vector<JointGrid> grids;  ///< one per machine.joints
  std::vector<Term> terms;
  std::vector<Input> inputs;
  std::vector<Observed> observed;  ///< only what the machine needs

  int observed_index(ObservedKind kind, int item) const;  ///< -1 if it is not there
};

/// Place of an observed temperature in the readings, which begin with the sensors; -1: not observed.
int reading_index(const mesh::Machine& machine, const Layout& layout, ObservedKind kind, int item);

/// Terms and inputs of the machine on the given grids, in a fixed order (films; joints, each with
/// its nodes; coolants: walls of each segment, then flow).
Layout make_layout(const mesh::Machine& machine, std::vector<JointGrid> grids);

}  // namespace thermotwin::solver
