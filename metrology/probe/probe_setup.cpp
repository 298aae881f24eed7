// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/probe/probe_setup.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::metrology {

namespace units = core::units;
namespace key = core::key;
using core::Absent;

namespace {

const core::KeyTable table{
    "probes",
    "The probes of an R-Test, whose readings are in raw.csv and whose calibration is in calibration.csv.",
    {
        key::word("mount", {"spindle", "table"}, "spindle",
                  "The side of the machine that carries the probes; the other side carries the sphere."),
        key::points("directions", "", Absent{"three, normal to each other, at equal angles to z"},
                    "Directions in which the probes measure, towards the sphere, with all axes at 0."),
        key::number("contact_radius_mm", "mm", {0.0, 1e4}, 0.0,
                    "Sum of the radii of a spherical tip and of the sphere; 0: flat tips."),
        key::number("noise_um", "um", {0.0, 1e3}, 0.1, "Standard deviation of one sample of a probe."),
        key::number("repeatability_um", "um", {0.0, 1e3}, 0.2,
                    "Repeatability of the linear axes: standard deviation of one coordinate at a point."),
        key::number("rate_Hz", "Hz", {0.1, 1e4}, 100.0, "Samples per second."),
        key::number("record_s", "s", {0.0, 1e4}, 3.0, "Recorded time at a point; 0 for a continuous test."),
        key::number("cut_s", "s", {0.0, 1e4}, 1.0, "Time that is left out at each end of this record."),
        key::number("calibration_mm", "mm", {1e-3, 100.0}, 2.0,
                    "Distance that each linear axis moves to either side in the calibration."),
    }};

}  // namespace

const core::KeyTable& probe_keys() { return table; }

double ProbeSetup::averaged() const { return std::max(1.0, std::floor((record - 2.0 * cut) * rate + 1e-9)); }

double ProbeSetup::std_of_point(double samples) const {
  // s = T^T m: of a coordinate the mean over the three.
  const Eigen::MatrixXd normal = directions * directions.transpose();
  const double share = normal.inverse().trace() / 3.0;
  return std::sqrt(repeatability * repeatability + noise * noise * share / samples);
}

ProbeSetup read_probes(const core::Node& node) {
  ProbeSetup setup;
  setup.on_table = node.choice("mount") == "table";
  setup.directions_stated = node.has("directions");
  setup.calibration_stated = node.has("calibration_mm");
  if (setup.directions_stated) setup.directions = node.points3("directions").transpose();
  for (Eigen::Index i = 0; i < setup.directions.cols(); ++i) {
    const double length = setup.directions.col(i).norm();
    if (!(length > 1e-9))
      throw core::InputError(node.place("directions"), "a direction of length 0", "three numbers that are not all 0");
    setup.directions.col(i) /= length;
  }
  require_spatial(setup.directions, node.has("directions") ? node.place("directions") : node.place());
  setup.contact_radius = node.number("contact_radius_mm") * units::mm;
  setup.noise = node.number("noise_um") * units::um;
  setup.repeatability = node.number("repeatability_um") * units::um;
  setup.rate = node.number("rate_Hz");
  setup.record = node.number("record_s");
  setup.cut = node.number("cut_s");
  setup.calibration = node.number("calibration_mm") * units::mm;
  if (setup.record > 0.0 && !(setup.record > 2.0 * setup.cut)) {
    throw core::InputError(node.place("record_s"), fmt::format("{} s", setup.record),
                           fmt::format("0, or more than twice cut_s = {}", setup.cut));
  }
  node.finish();
  return setup;
}

std::string probes_text(const ProbeSetup& setup) {
  std::string text = fmt::format("[probes]\nmount = \"{}\"\ndirections = [", setup.on_table ? "table" : "spindle");
  for (Eigen::Index i = 0; i < setup.directions.cols(); ++i) {
    const Eigen::Vector3d d = setup.directions.col(i);
    text += fmt::format("{}[{:.12g}, {:.12g}, {:.12g}]", i == 0 ? "" : ", ", d.x(), d.y(), d.z());
  }
  text += fmt::format(
      "]\ncontact_radius_mm = {:.12g}\nnoise_um = {:.12g}\nrepeatability_um = {:.12g}\nrate_Hz = {:.12g}\nrecord_s = "
      "{:.12g}\ncut_s = {:.12g}\ncalibration_mm = {:.12g}\n",
      setup.contact_radius / units::mm, setup.noise / units::um, setup.repeatability / units::um, setup.rate,
      setup.record, setup.cut, setup.calibration / units::mm);
  return text;
}

}  // namespace thermotwin::metrology
