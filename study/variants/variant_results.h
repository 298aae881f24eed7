// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Gathers the tables of the units: quantiles of the TCP error at each pose and time over the machines of a group, and
// the sensitivities of the three translations at all poses and times together, and at each pose.

#include <Eigen/Core>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/table.h"
#include "study/plan/design.h"
#include "study/statistics/sensitivity.h"
#include "study/variants/variant_unit.h"

namespace thermotwin::study {

/// The length of the TCP error of one variant, over all poses.
struct VariantError {
  std::size_t variant = 0;  ///< index into the design
  double largest_um = 0, largest_at_s = 0, end_um = 0;
};

struct LoadStudy {
  std::string load;
  std::vector<VariantError> errors;  ///< of the variants with results
  /// time_s, axes, then error_um (length of the translation), dx_um ... rc_um_per_m with _q05, _q50 and _q95 each
  core::Table quantiles;
  std::optional<Sensitivity> sensitivity;         ///< of all poses and times together
  std::vector<Sensitivity> at_poses;              ///< one for each pose, over all times; empty without sensitivity
  double largest_q50_um = 0, largest_q95_um = 0;  ///< over poses and times, of the length
};

struct GroupStudy {
  std::string name;
  std::size_t variants = 0;        ///< variants with results
  std::size_t asked = 0;           ///< variants of the plan
  std::string why_no_sensitivity;  ///< empty: there are sensitivities, or the plan draws no parameter
  std::vector<LoadStudy> loads;
};

/// A variant that could not be computed with a load program.
struct FailedVariant {
  std::size_t variant = 0;
  std::string load, reason;
};

struct VariantStudy {
  std::vector<std::string> drawn;  ///< names of the drawn parameters
  std::vector<GroupStudy> groups;
  std::vector<mesh::Pose> poses;
  std::vector<std::string> missing;       ///< descriptions of units that have not been tried
  std::vector<std::string> failed_units;  ///< descriptions of units that failed, with their reasons
  std::vector<FailedVariant> failed;      ///< by variant
  std::size_t units_done = 0;
  int loads = 0;                        ///< load programs of the plan
  std::vector<int> results;             ///< (variants) load programs with results
  std::size_t computed() const;         ///< variants with results of all load programs
  std::size_t failed_variants() const;  ///< variants that failed with at least one
};

/// @return indices of the drawn parameters, the largest total share (Sobol) of the variance first
std::vector<std::size_t> by_total(const Sensitivity& sensitivity);

/// A parameter matters if its total share is at least this, and the 95 % interval of the share excludes 0.
inline constexpr double share_that_matters = 0.02;
/// @return indices of the drawn parameters that matter, the largest total share first
std::vector<std::size_t> that_matter(const Sensitivity& sensitivity);

/// Heads and rows of errors.csv: variant, group, load, largest error, its time, the error at the end.
/// @param with_values  with those values of the parameters that differ between variants
/// @param most         rows at most
std::vector<std::vector<std::string>> error_rows(const StudyPlan& plan, const Design& design,
                                                 const VariantStudy& results, bool with_values, std::size_t most);

/// @param study  folder of the study
VariantStudy gather(const std::filesystem::path& study, const StudyPlan& plan, const Design& design,
                    const std::vector<VariantUnit>& units);

/// Writes GROUP/LOAD/quantiles.csv, sensitivities.csv and sensitivities_by_pose.csv, variants.csv, errors.csv with
/// the TCP error of each variant, and failures.csv where variants failed.
/// @throws InputError
void write_results(const std::filesystem::path& study, const StudyPlan& plan, const Design& design,
                   const VariantStudy& results);

}  // namespace thermotwin::study
