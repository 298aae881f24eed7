// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Identification of transfer functions from a record: ARX by least squares, ARMAX by repeated least squares with the
// noise's own past, output error by a gradient search on the simulated output (what a compensation does: it never sees
// the displacement). Unstable poles are mirrored and the numerators fitted again; output error allows for a machine
// that does not start settled.

#include <string>
#include <utility>
#include <vector>

#include "compensation/models/transfer_function.h"

namespace thermotwin::compensation {

enum class TransferMethod { arx, armax, output_error };

/// What is chosen by the data.
struct TransferStructure {
  Eigen::Index order = 1;
  /// The record starts at rest, as calibrations do (documents 001, 002), and is fitted so. Else each input may bring a
  /// free motion of its own; in one short record that takes the place of slow poles, and the prediction, which starts
  /// settled, is far off.
  bool settled = false;
};

/// Simulated error on thirds of the known samples that the fit did not see.
/// @param radius  largest magnitude of a pole  @param label  of the channel, for messages
/// @throws InputError  for too few samples, or no finite output
double held_out_error(const Grid& grid, const std::vector<InputInfo>& info, TransferMethod method,
                      const TransferStructure& structure, double radius, const std::string& label);

/// Fits all known samples; whether the record starts settled is chosen by what it leaves.
std::pair<TransferStructure, TransferSet> fit_transfer(const Grid& grid, const std::vector<InputInfo>& info,
                                                       Eigen::Index order, double radius, const std::string& label,
                                                       TransferMethod method);

}  // namespace thermotwin::compensation
