// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Film coefficients in W/(m^2 K) in air: free convection on plates and walls, rotating disc,
// linearised radiation. Source: Gebhardt (2014) Fig. 5.3, (5.10)-(5.16); the wall law is
// Churchill-Chu with its square. Rotating disc: (5.13) laminar up to Re 260,000, (5.15) turbulent from
// 320,000, as printed; between them the power of Re that joins both, Re^3.98. The printed transition
// (5.14) starts 36 % below the laminar law and ends at half of the turbulent one, so it is not used;
// the exponent agrees with the Re^4 of Popiel and Boguslawski (Int. J. Heat Mass Transfer 18, 1975).

#include "mesh/machine/machine.h"

namespace thermotwin::solver {

/// Properties of air used throughout: conductivity 0.0268 W/(m K), kinematic viscosity
/// 16.1e-6 m^2/s, Prandtl number 0.7.
/// @param length  characteristic length, m  @param delta  |surface - air|, K  @param air_K absolute
double free_convection(mesh::Orientation orientation, double length, double delta, double air_K);

/// Nusselt number of a plate or wall at a Rayleigh number.
double natural_nusselt(mesh::Orientation orientation, double rayleigh);

/// @param speed  rad/s, sign ignored  @param radius m
double rotating_disc(double speed, double radius);
double rotating_disc_nusselt(double reynolds);

/// 4 eps sigma T^3. @param temperature_K absolute
double radiation(double emissivity, double temperature_K);
/// eps sigma (T^4 - U^4) / (T - U), exact between two temperatures. @param temperature_K, surroundings_K absolute
double radiation_between(double emissivity, double temperature_K, double surroundings_K);

}  // namespace thermotwin::solver
