// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/fit/arc_study.h"

#include <Eigen/LU>

#include <cmath>
#include <numbers>
#include <random>

#include "core/dense_algebra.h"
#include "core/range.h"
#include "core/statistics.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "metrology/fit/arc_fit.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::MatrixX3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

namespace {

constexpr double least_drawn = 0.5 * least_span;  ///< the noise of a draw shortens an arc of the least span

double feed_of(const ArcStudy& study) { return study.feed > 0.0 ? study.feed : 600.0 * core::units::deg_min; }

VectorXd angles_of(const ArcStudy& study) {
  const Index n = static_cast<Index>(std::floor(study.span / feed_of(study) * study.rate * (1.0 + 1e-12))) + 1;
  return VectorXd::LinSpaced(n, -0.5 * study.span, 0.5 * study.span);
}

}  // namespace

void ArcStudy::validate() const {
  const std::string field = "arc study: ";
  core::require_within(field + "span, deg", span / core::units::deg, {least_span / core::units::deg, 360.0});
  core::require_within(field + "radius, mm", radius / core::units::mm, {1.0, 1e5});
  core::require_within(field + "half width, um", half_width / core::units::um, {1e-6, 1e3});
  core::require_within(field + "rate, Hz", rate, {1e-3, 1e6});
  core::require_within(field + "feed, deg/min", feed / core::units::deg_min, {0.0, 1e6});
  core::require_within(field + "plane offset, mm", plane_offset / core::units::mm, {-1e5, 1e5});
  core::require_within(field + "draws", draws, {2, 1e6});
  core::require_within(field + "points of one arc", span / feed_of(*this) * rate, {3, 1e6});
}

ArcStudyResult study_arc(const ArcStudy& study) {
  study.validate();
  const VectorXd angles = angles_of(study);
  const Index n = angles.size();
  MatrixX3d nominal(n, 3);
  nominal << study.radius * angles.array().cos(), study.radius * angles.array().sin(),
      VectorXd::Constant(n, study.plane_offset);
  const ArcFrame frame;
  ArcStudyResult result;
  result.points = n;
  result.draws.resize(study.draws, 4);
  core::parallel_for(
      0, study.draws,
      [&](std::size_t i) {
        std::mt19937_64 random(study.seed * 0x9E3779B97F4A7C15ULL + i + 1);
        MatrixX3d points = nominal;
        for (Index k = 0; k < points.size(); ++k)
          points.data()[k] += study.half_width * (2.0 * core::uniform(random) - 1.0);
        const ArcFit fit = fit_arc(points, frame, study.method, "arc study", least_drawn);
        result.draws.row(i) << fit.centre.transpose(), -fit.tilt[1], fit.tilt[0];
      },
      16);
  const Eigen::MatrixX4d about = result.draws.rowwise() - result.draws.colwise().mean();
  result.std = (about.colwise().squaredNorm().transpose() / (study.draws - 1)).cwiseSqrt();
  result.range = (result.draws.colwise().maxCoeff() - result.draws.colwise().minCoeff()).transpose();

  MatrixXd rows(n, 3);
  rows << angles.array().cos(), angles.array().sin(), VectorXd::Ones(n);
  const MatrixXd cofactor = (rows.transpose() * rows).inverse();
  const double deviation = study.half_width / std::sqrt(3.0);
  for (int i = 0; i < 2; ++i) {
    const double centre = deviation * std::sqrt(cofactor(i, i)), tilt = centre / study.radius;
    result.theory[2 + i] = tilt;
    result.theory[i] = std::hypot(centre, tilt * study.plane_offset);
  }
  return result;
}

}  // namespace thermotwin::metrology
