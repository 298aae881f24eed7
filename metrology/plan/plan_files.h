// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A plan as a folder: program.nc, load.toml, rows.csv for `compensate`, points.csv and plan.toml for the simulation.
// An R-Test has rtest.toml too: with raw.csv and calibration.csv of the machine, `measure analyse` reads the folder.

#include <filesystem>
#include <string>
#include <vector>

#include "core/key_table.h"
#include "metrology/plan/test_plan.h"
#include "metrology/probe/probe_setup.h"

namespace thermotwin::metrology {

/// Moves the machine's tool point. @param offset  m, machine frame with all axes at 0
void move_tool_point(mesh::Machine& machine, const Eigen::Vector3d& offset);

/// @param machine  with the tool point of the test @throws InputError, nothing is left half written
void write_plan(const std::filesystem::path& folder, const mesh::Machine& machine, const TestPlan& plan,
                const ProbeSetup& probes, const Eigen::Vector3d& tool_offset);

/// rtest.toml of a test on this machine. @param std  m, of one coordinate of a point @param more  lines below the keys
std::string rtest_text(const mesh::Machine& machine, double std, const std::string& more);

/// What a simulation needs of a plan.
struct PlanFolder {
  std::string kind;
  std::string tested;                                     ///< id of the axis; empty: none
  Eigen::Vector3d tool_offset = Eigen::Vector3d::Zero();  ///< m
  ProbeSetup probes;
  std::filesystem::path load;
  std::vector<PlannedPoint> points;
  bool is_rtest = false;
};

/// @throws InputError: a missing file, an unknown key, a plan of another machine, a point outside the travel
PlanFolder read_plan(const std::filesystem::path& folder, const mesh::Machine& machine);

const core::KeyTable& plan_keys();

}  // namespace thermotwin::metrology
