// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Factors from the units of files to the SI units of the code: `200.0 * units::mm` is 0.2 m, and `length / units::um`
// is the number for a column that ends in _um.

#include <numbers>

namespace thermotwin::core::units {

inline constexpr double m = 1.0;
inline constexpr double mm = 1e-3;
inline constexpr double um = 1e-6;
inline constexpr double inch = 25.4e-3;  // exact
inline constexpr double litre = 1e-3;    // m^3
inline constexpr double deg = std::numbers::pi / 180.0;
inline constexpr double um_per_m = 1e-6;  // rad
inline constexpr double minute = 60.0;
inline constexpr double hour = 3600.0;
inline constexpr double mm_min = mm / minute;                   // feed, m/s
inline constexpr double deg_min = deg / minute;                 // feed, rad/s
inline constexpr double rpm = 2.0 * std::numbers::pi / minute;  // rad/s
inline constexpr double GPa = 1e9;
inline constexpr double N_mm3 = 1e9;           // contact stiffness per area, N/m^3
inline constexpr double zero_C_in_K = 273.15;  // to be added for radiation laws only

}  // namespace thermotwin::core::units
