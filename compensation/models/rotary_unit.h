// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Lumped physical model of a rotary and swivel unit (Gebhardt 2014, 5.1 to 5.25): table t, upper and
// lower body of the C unit c1 and c2, swivel body s and bed b, each of one temperature,
//   m c dT/dt = sum G (T_other - T) + film A (T_air - T) + P - U (T - T_inlet).
// Drive heat goes to table and c1 (C) and to s (swivel). Films are free convection (5.9 to 5.11), on the
// table a rotating disc (5.12 to 5.16), of which c1 sees 0.3, c2 and s 0.1 (5.17 to 5.19). U stands for
// the coolant (5.20); its inlet is measured, or guided by the bed. Location errors (a expansion, d
// effective lengths of Table 5.4), layout B/C:
//   Y0C = a (d1 Tc1 + d2 Ts)           Z0T = a (d3 Tt + (d4 Tc1 + d5 Tc2) / 2)
//   R0T = a r Tt                       A0C = a d1 (Tc1 - Tc2) / d6
// Layout A/C is the same unit turned: X0C and X0T for Y0C, B0C for A0C; and of the A axis
//   Z0A = a d2 Ts / 2, A0A = a d2 (Ts - Tb) / d6 (ours: the source measures them, its equations stop at B/C).
// Calibration, left to hand work in the source: capacities, conductances, films, cooling, the share of
// the table and, where no drive power is measured, the loss laws are fitted to all channels together, each
// with a prior about the values of such a unit; k1 of (5.25) is solved exactly for each channel beside an
// intercept, and k2 is the time constant of a first-order lag, which for a step is the printed factor.

#include <memory>
#include <string>
#include <vector>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

/// One channel of the unit: its training data (the same inputs for all) and its quantity.
struct UnitChannel {
  TrainingData data;
  std::string quantity;  ///< Y0C Z0T R0T A0C X0C X0T B0C Z0A A0A, or dx dy dz ra rb of a TCP error
};

/// Indices of the inputs that the model uses: drives and speeds of C and the swivel axis, the air, a
/// coolant inlet. @throws InputError where C neither moves nor takes power
std::vector<Eigen::Index> rotary_unit_inputs(const std::vector<InputInfo>& info, const std::string& label);

/// Fits all channels together. @return models in their order; nullptr where the equations do not have
/// the quantity, with the reason in left_out
std::vector<std::unique_ptr<ChannelModel>> fit_rotary_unit(const std::vector<UnitChannel>& channels,
                                                           std::vector<std::string>& left_out);

/// Empty, to be loaded.
std::unique_ptr<ChannelModel> make_rotary_unit();

}  // namespace thermotwin::compensation
