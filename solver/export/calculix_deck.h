// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Decks for CalculiX (ccx 2.20) of a meshed machine, or of one of its bodies, at one pose:
//   heat.inp    heat transfer, transient over a load program (one *STEP for each run of equal time
//               steps, implicit Euler with fixed increments) or steady
//   static.inp  thermo-elastic displacement at the temperatures that heat.inp left in heat.frd
//   mesh.inp    nodes and elements of both (C3D4 or C3D10); heat_only.inp: of bodies that are not elastic
// in SI units and degC, bodies where the pose puts them. What becomes of the machine's parts:
//   film, mount, coolant wall -> *FILM, coefficient and sink as amplitudes of the increments' ends
//   source -> *DFLUX on a surface; at a joint *CFLUX, shared as the areas in contact are
//   joint -> heat: face-to-face contact, TIED, with *GAP CONDUCTANCE, integrated by ccx itself;
//            elasticity: *SPRING between mean displacements of pads (*EQUATION), as elastic/springs.h
//            has them: ccx's own tied contact has no free direction and pulls a gap shut
//   scale -> *EQUATION with the expansion of a one-element thermometer at the tape's mean temperature
// Not in a deck, and said in it: axes that move, coolant that flows, chillers that control.

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "solver/operation/load_program.h"

namespace thermotwin::solver {

struct DeckOptions {
  mesh::Pose pose;                       ///< empty: home
  const LoadProgram* program = nullptr;  ///< none: steady state of the machine as it stands (Channels)
  double steady_at = -1;                 ///< s; >= 0: steady state of what the program has at this time
  double refine = 1.0;                   ///< factor of the program's longest time step
  std::string body;                      ///< only this one, free of the others; empty: the machine
  bool heat_only = false;                ///< no static.inp; nor is there one where no body is elastic
  void validate() const;                 ///< @throws InputError
};

struct DeckSummary {
  std::vector<std::string> files;        ///< names in the folder, in the order of writing
  std::vector<std::string> notes;        ///< what the deck approximates or leaves out, a sentence each
  Eigen::Index nodes = 0, elements = 0;  ///< of the bodies
  long increments = 0;                   ///< of heat.inp; 1: steady
  std::size_t steps = 0;                 ///< *STEPs of heat.inp
  double end = 0;                        ///< s
};

/// Writes all files or none.
/// @throws InputError (unknown body, a time outside the program, nothing that gives a temperature a
///         level in a steady state), MeshError (an elastic body that no joint holds)
DeckSummary write_calculix_deck(const std::filesystem::path& folder, const mesh::MachineMesh& mesh,
                                const DeckOptions& options = {});

}  // namespace thermotwin::solver
