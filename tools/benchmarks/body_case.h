// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One body of a machine, alone: films on its skin and foot, heat on one surface. The same problem is
// handed to other programs as a text file (for the bare CHOLMOD program) and as decks for CalculiX.

#include <filesystem>
#include <string>

#include "mesh/machine_mesh.h"

namespace thermotwin::bench {

struct BodyCase {
  mesh::MachineMesh mesh;  ///< one body; surfaces "bench.skin", "bench.foot", "bench.heated"
  double step_s = 60.0;
};

/// The foot is the body's surface that holds the most area of joints with what carries it, the
/// heated surface the one that a source names first.
/// @throws InputError for an unknown body
BodyCase body_case(const mesh::Machine& machine, const std::string& body, double size_factor,
                   const std::filesystem::path& cache);

inline constexpr double skin_film = 8.0, foot_film = 200.0;  // W/(m^2 K)
inline constexpr double air_K = 3.0, foundation_K = -1.0;    // above the reference
inline constexpr double heat_W = 300.0;
/// Adjoint columns of the elastic comparison: unit forces in x, y, z at nodes spread over the body.
inline constexpr int load_nodes = 16;

/// Node of the i-th group of three unit forces.
inline Eigen::Index load_node(Eigen::Index nodes, int i) { return nodes * i / load_nodes; }

void write_plain(const std::filesystem::path& file, const BodyCase& one);

/// Decks NAME.inp in the folder: "heat_short" and "heat_long" take 2 and 2 + steps time steps of heat
/// conduction, "bend_short" and "bend_long" one and three static thermo-elastic steps.
void write_decks(const std::filesystem::path& folder, const BodyCase& one, int steps);

}  // namespace thermotwin::bench
