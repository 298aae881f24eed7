// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/film_laws.h"

#include <cmath>

namespace thermotwin::solver {

namespace {

constexpr double air_conductivity = 0.0268;  // W/(m K)
constexpr double air_viscosity = 16.1e-6;    // m^2/s
constexpr double prandtl = 0.7;
constexpr double gravity = 9.81;  // m/s^2
constexpr double stefan_boltzmann = 5.670374419e-8;

}  // namespace

double natural_nusselt(mesh::Orientation orientation, double rayleigh) {
  switch (orientation) {
    case mesh::Orientation::up: return rayleigh <= 1e7 ? 0.54 * std::pow(rayleigh, 0.25) : 0.15 * std::cbrt(rayleigh);
    case mesh::Orientation::down: return 0.27 * std::pow(rayleigh, 0.25);
    case mesh::Orientation::vertical: break;
  }
  const double denominator = std::pow(1.0 + std::pow(0.492 / prandtl, 9.0 / 16.0), 8.0 / 27.0);
  const double root = 0.825 + 0.387 * std::pow(rayleigh, 1.0 / 6.0) / denominator;
  return root * root;
}

double free_convection(mesh::Orientation orientation, double length, double delta, double air_K) {
  const double grashof = gravity * length * length * length * std::abs(delta) / (air_viscosity * air_viscosity * air_K);
  return natural_nusselt(orientation, grashof * prandtl) * air_conductivity / length;
}

double rotating_disc_nusselt(double reynolds) {
  constexpr double ends = 260e3, begins = 320e3;  // laminar up to, turbulent from
  const auto laminar = [](double re) { return 0.355 * std::sqrt(re); };
  const auto turbulent = [](double re) { return 0.0163 * std::pow(re, 0.8); };
  if (reynolds <= ends) return laminar(reynolds);
  if (reynolds >= begins) return turbulent(reynolds);
  const double share = std::log(reynolds / ends) / std::log(begins / ends);
  return std::pow(laminar(ends), 1.0 - share) * std::pow(turbulent(begins), share);
}

double rotating_disc(double speed, double radius) {
  const double reynolds = std::abs(speed) * radius * radius / air_viscosity;
  return reynolds > 0.0 ? rotating_disc_nusselt(reynolds) * air_conductivity / radius : 0.0;
}

double radiation(double emissivity, double temperature_K) {
  return 4.0 * emissivity * stefan_boltzmann * temperature_K * temperature_K * temperature_K;
}

double radiation_between(double emissivity, double temperature_K, double surroundings_K) {
  return emissivity * stefan_boltzmann * (temperature_K * temperature_K + surroundings_K * surroundings_K) *
         (temperature_K + surroundings_K);
}

}  // namespace thermotwin::solver
