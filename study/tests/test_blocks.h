// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Blocks that a test is made of: stretches of a load program with the standstills in which a probe measures. Standard
// blocks keep a load, or change it at random in intervals (Gebhardt 2014, 5.2.1; metrology/plan/load_intervals.h).

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine/machine.h"
#include "solver/operation/load_program.h"

namespace thermotwin::study {

inline constexpr const char* probe_phase = "probe";  ///< name of the standstills in which it measures

struct TestPhase {
  std::string name;
  double seconds = 0;
  Eigen::VectorXd from, to;  ///< (channels) at its ends, linear between
  bool probes = false;       ///< a standstill, at whose end the probe is read
};

struct TestBlock {
  std::string name;
  std::vector<TestPhase> phases;
  double seconds() const;
};

struct BlockOptions {
  double block_s = 3600;        ///< length of a standard block
  double interval_s = 300;      ///< between changes of a random cycle
  double probe_every_s = 3600;  ///< between readings of the probe; 0: there is none
  double probe_s = 60;          ///< standstill of a reading
  mesh::Pose probe_pose;        ///< at which the probe stands
  std::uint64_t seed = 1;       ///< of the random cycles
  void validate() const;        ///< @throws InputError
};

/// Standstill with and without coolant and cutting fluid, spindle, each axis, all at once; steady and as random cycles;
/// the spindle at both ends of the travels. The largest feed is half of the rapid, since the other half of the time
/// goes into acceleration and braking.
std::vector<TestBlock> standard_blocks(const mesh::Machine& machine, const BlockOptions& options);

/// Standstill, then the spindle, then one axis after another (the order of clauses 5 to 8 of ISO 230-3), each with an
/// equal share of the time, of which a load takes two thirds and the standstill behind it one.
std::vector<TestBlock> iso_230_3_blocks(const mesh::Machine& machine, const BlockOptions& options, double seconds);

/// A load program as a block. @param seconds  that are taken of it at most
TestBlock program_block(const mesh::Machine& machine, const solver::LoadProgram& load, const BlockOptions& options,
                        double seconds);

/// Whether a program sets the temperature of surroundings to another value than machine.toml's default_C.
bool moves_surroundings(const mesh::Machine& machine, const solver::LoadProgram& load);

/// The blocks as a load program (loads/*.toml). @param output_s  interval of its outputs
std::string test_text(const mesh::Machine& machine, const std::vector<const TestBlock*>& blocks,
                      const std::string& title, double initial_C, double output_s);

}  // namespace thermotwin::study
