// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The arrays of a block of online data, and their agreement with the machine that the block holds too.

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "compensation/control/online_data.h"

namespace thermotwin::compensation {

/// The matrices of a block.
struct OnlineBlock {
  enum Place : std::size_t {
    capacity,  ///< empty: 1
    conduction,
    inputs,
    sensors,
    one_kelvin,
    tool_poses,   ///< a column each
    table_poses,  ///< a column each
    errors,       ///< a column each, of error_numbers
    guard,        ///< largest offset and rate
    of_axes,      ///< slope and rapid, a column each
    count
  };
};
/// Arrays as a block holds them, before they are compared with the machine.
struct OnlineArrays {
  std::string machine, size;
  std::int64_t full_size = 0;
  std::vector<std::int32_t> grids;  ///< axis, periodic and number of positions of each joint's grid
  std::vector<double> positions;
  std::vector<std::string> loads;
  std::vector<Eigen::MatrixXd> matrices, tool, table_axis, table_own;
};

std::vector<Eigen::MatrixXd> matrices_of(const OnlineData& data);

/// Fills the model from the arrays; its machine, and the terms of `derived`, are there already.
/// @param name  of the block, in messages  @throws InputError  for arrays that do not belong to the machine
void fill_from(OnlineArrays arrays, const std::string& name, OnlineData& data);

/// @throws InputError always  @param name  of the block
[[noreturn]] void refuse_online_data(const std::string& name, const std::string& found);

}  // namespace thermotwin::compensation
