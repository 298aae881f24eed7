// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/probe/probes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::metrology {
namespace {

using core::units::mm;
using core::units::um;
using Eigen::Vector3d;

/// Calibration by +-2 mm with probes of the given directions whose zero is somewhere.
core::Table calibration(const Eigen::Matrix3Xd& directions, double contact_radius, bool centre = true,
                        const std::vector<int>& left_out = {}) {
  core::Table table;
  table.source = "calibration.csv";
  table.columns = {"x_mm", "y_mm", "z_mm"};
  for (Eigen::Index k = 0; k < directions.cols(); ++k) table.columns.push_back("P" + std::to_string(k + 1) + "_um");
  std::vector<Eigen::VectorXd> rows;
  for (int i = centre ? 0 : 1; i < 7; ++i) {
    if (std::find(left_out.begin(), left_out.end(), i) != left_out.end()) continue;
    Vector3d moved = Vector3d::Zero();
    if (i > 0) moved[(i - 1) / 2] = i % 2 == 1 ? -2 * mm : 2 * mm;
    Eigen::VectorXd row(3 + directions.cols());
    const Eigen::VectorXd zero = Eigen::VectorXd::LinSpaced(directions.cols(), 0.1 * mm, 0.4 * mm);
    row << moved / mm, (probe_readings(directions, contact_radius, moved) + zero) / um;
    rows.push_back(row);
  }
  table.values.resize(std::ssize(rows), 3 + directions.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) table.values.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  return table;
}

Eigen::VectorXd zero_of(const Eigen::Matrix3Xd& directions) {
  return Eigen::VectorXd::LinSpaced(directions.cols(), 0.1 * mm, 0.4 * mm);
}

TEST(Probes, FlatTipsAreLinear) {
  // Four probes that are not normal to each other, as in (4.2), whose print lacks one plateau.
  Eigen::Matrix3Xd directions(3, 4);
  directions << 1, 0.2, 0, -0.6, 0, 1, 0.3, -0.6, 0.1, 0.1, 1, 0.5;
  directions.colwise().normalize();
  const Vector3d moved(0.05 * mm, -0.3 * mm, 0.7 * mm);
  for (const std::vector<int>& left_out : {std::vector<int>{}, std::vector<int>{4}}) {
    const Calibration fit = Calibration::fit(calibration(directions, 0.0, false, left_out), 0.0);
    const Vector3d found = fit.displacement(probe_readings(directions, 0.0, moved) + zero_of(directions));
    EXPECT_LT((found - moved).norm(), 1e-12);
    EXPECT_LT(fit.residual_rms(), 1e-12);
  }
}

TEST(Probes, ContactOfSpheresIsTakenOut) {
  const Eigen::Matrix3Xd directions = tripod();
  constexpr double radius = 12.5 * mm;
  const Vector3d moved(0.3 * mm, -0.2 * mm, 0.4 * mm);
  const Eigen::VectorXd readings = probe_readings(directions, radius, moved) + zero_of(directions);
  // At right angles to a probe, 0.5 mm adds (0.5 mm)^2 / 2 / 12.5 mm = 10 um.
  const Vector3d across = directions.col(0).unitOrthogonal() * 0.5 * mm;
  EXPECT_NEAR(probe_readings(directions, radius, across)[0], 10.004 * um, 1e-9);
  const Calibration fit = Calibration::fit(calibration(directions, radius), radius);
  EXPECT_LT((fit.displacement(readings) - moved).norm(), 1e-9);
  // As if the tips were flat, the error is micrometres.
  const Calibration flat = Calibration::fit(calibration(directions, radius), 0.0);
  EXPECT_GT((flat.displacement(readings) - moved).norm(), 2 * um);
}

std::string refused(const core::Table& table, double contact_radius) {
  try {
    Calibration::fit(table, contact_radius);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Probes, SingularArrangementsAreRefused) {
  Eigen::Matrix3Xd plane(3, 3);
  plane << 1, 0, 0.6, 0, 1, 0.8, 0, 0, 0;
  EXPECT_NE(refused(calibration(plane, 0.0), 0.0).find("different directions"), std::string::npos);
  EXPECT_NE(refused(calibration(plane.leftCols(2), 0.0), 0.0).find("7 displacements of 2 probes"), std::string::npos);
  EXPECT_NE(refused(calibration(tripod(), 0.0, true, {5, 6}), 0.0).find("along x, y and z"), std::string::npos);
  EXPECT_NE(refused(calibration(tripod(), 0.01, false), 0.01).find("no row at 0, 0, 0"), std::string::npos);
  core::Table gap = calibration(tripod(), 0.0);
  gap.values(3, 4) = std::nan("");
  EXPECT_NE(refused(gap, 0.0).find("calibration.csv:5"), std::string::npos) << refused(gap, 0.0);
}

}  // namespace
}  // namespace thermotwin::metrology
