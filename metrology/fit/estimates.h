// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Linear least squares for the few parameters of a cycle of measured points, and its results over time. Columns are
// scaled to norm 1; directions whose singular value is below `weakest` of the largest are not observable. A parameter
// that takes part in one of them has no value. With rows of standard deviation 1 the covariance is (A^T A)^-1.

#include <Eigen/Core>

#include <string>
#include <vector>

namespace thermotwin::metrology {

struct Harmonic {
  int order = 0;
  Eigen::Vector3d cosine, sine;  ///< m, frame of the body on which the axis stands
};

struct CycleResult {
  double time = 0;             ///< s, middle of the cycle
  Eigen::VectorXd value, std;  ///< (errors) SI, of their units; NaN: not observable
  Eigen::MatrixXd covariance;  ///< (errors x errors) products of these units; NaN as value
  bool drift_estimated = false;
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();      ///< m, over the cycle; 0: not estimated
  Eigen::Vector3d drift_std = Eigen::Vector3d::Zero();  ///< m
  std::vector<Harmonic> harmonics;
  Eigen::VectorXd residual;  ///< (rows) m, measured less fitted, of the cycle itself
  double residual_rms = 0;   ///< m, of a coordinate
  /// (errors x rows) values = functional * measured; NaN: not observable. Empty: more than most_functional_rows.
  Eigen::MatrixXd functional;
  int rank = 0, parameters = 0;
  Eigen::Index degrees_of_freedom = 0;
};

struct Estimates {
  std::vector<std::string> errors;  ///< X0C, EXX1, dx, dome ...
  std::vector<std::string> units;   ///< um, um/m, um/m2, um/m3
  std::vector<CycleResult> cycles;  ///< as differences to the first cycle, the first entry is zero
  /// Errors that at least one cycle cannot observe, with those that have the same effect: "Y0B: not observable: the
  /// points do not distinguish it from Y0C". Empty: all are observable.
  std::vector<std::string> not_observable;
  std::vector<std::string> not_estimated;  ///< left out, with those that act alike: "EYX2 from ECX1"

  bool turns(std::size_t error) const { return units[error] == "um/m"; }
  std::vector<std::size_t> observed() const;  ///< errors that all cycles observe
};

struct LinearFit {
  Eigen::VectorXd value;       ///< (parameters)
  Eigen::MatrixXd inverse;     ///< (parameters x rows) value = inverse * right
  Eigen::MatrixXd cofactor;    ///< (parameters x parameters)
  Eigen::MatrixXd unobserved;  ///< (parameters x directions), in the scaled parameters
  Eigen::VectorXd residual;    ///< (rows)

  bool hides(Eigen::Index parameter) const;
  /// What has the same effect as a hidden parameter. @param names  of the first parameters  @param others  of the rest
  std::string same_effect(const std::vector<std::string>& names, Eigen::Index parameter,
                          const std::string& others) const;
};

inline constexpr Eigen::Index most_functional_rows = 90000;  ///< 30,000 points

inline constexpr double weakest = 1e-7;  ///< smallest singular value over the largest that counts as observed

/// @param rows  (rows x parameters)
LinearFit fit_linear(const Eigen::MatrixXd& rows, const Eigen::VectorXd& right);

/// Takes the observable ones of the first parameters. @param variance  of a row
CycleResult cycle_result(const LinearFit& fit, Eigen::Index errors, double variance);

constexpr double residual_probability = 0.001;  ///< of a chi-square that exceeds what is stated, by chance

/// The residuals of all cycles against the stated uncertainty of a row.
struct ResidualTest {
  Eigen::Index degrees = 0;
  double ratio = 0;      ///< Birge ratio: RMS residual per degree of freedom over the uncertainty; NaN: none
  bool exceeds = false;  ///< chi-square above its quantile of 99.9 %
};
ResidualTest residual_test(const Estimates& estimates, double std);

/// If against_first, subtracts the first cycle from each and adds its covariance. Then sets the standard deviations.
void complete(std::vector<CycleResult>& cycles, bool against_first);

}  // namespace thermotwin::metrology
