// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Online validation: machines measured virtually (perturbed parameters, another mesh, other time
// steps, noise) run unseen load programs, the compensator runs beside them from inputs and sensors
// alone, and the TCP error before and after is compared at the check points.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "compensation/evaluation/measured_machines.h"
#include "core/statistics.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"

namespace thermotwin::compensation {

/// Cells of a table, its header first. That of another truth has the same header, so that both print side by side.
using Rows = std::vector<std::vector<std::string>>;

struct ValidationOptions {
  std::vector<std::string> loads;  ///< names of load programs
  int draws = 5;
  std::uint64_t first_seed = 1;                        ///< draw i perturbs and adds noise with first_seed + i
  VirtualOptions machine;                              ///< mesh, steps, noise of the measured machine
  std::filesystem::path keep;                          ///< where full runs are kept; empty: they are not
  const reduction::ReducedModel* reference = nullptr;  ///< truth instead of the full model
  int traced_draws = 0;                                ///< errors over time of so many draws are kept
  double rate_um_s = 0;                                ///< of the guard in a study of restarts; 0: by the model
  void validate() const;                               ///< @throws InputError
};

/// RMS over time of the translations' error vector at one check point, with the offsets as the guard lets them through
/// (offset_guard.h), moved through the linear axes, from five minutes after the start on, when they have gone in.
struct ValidationRow {
  std::string load;
  int draw = 0;
  std::string pose;
  double rms_before_um = 0;   ///< no compensation
  double rms_model_um = 0;    ///< reduced model, no temperature sensor; surroundings at their defaults
  double rms_told_um = 0;     ///< the same, told that what surrounds the machine is as warm as the hall
  double rms_sensors_um = 0;  ///< reduced model with observer
  double rms_unmoved_um = 0;  ///< the part, of each of the four, in directions that no linear axis moves
  double largest_before_um = 0, largest_sensors_um = 0;
};

/// The translations' error over time at one check point, before and after.
struct ValidationTrace {
  std::string load;
  int draw = 0;
  std::string pose;
  Eigen::VectorXd hours;                ///< (rows)
  Eigen::Matrix3Xd before_um, left_um;  ///< (3 x rows) measured; what the offsets with sensors leave of it
  Eigen::Matrix3Xd unmoved_um;          ///< (3 x rows) the part of both in directions that no linear axis moves
  /// (3 x rows) one standard deviation of the rest of left_um as the compensator states it; nought: no axis moves there
  Eigen::Matrix3Xd std_um;
  Eigen::Vector3d noise_um;  ///< standard deviation of the measured values

  /// (3 x rows) two standard deviations of the residual, the measurement's noise in it; nought where nothing is stated.
  Eigen::Matrix3Xd band_um() const;
  /// Residuals with a stated deviation, and how many of them lie within the band.
  std::pair<Eigen::Index, Eigen::Index> coverage() const;
};

enum class With { model, told, sensors };

struct Validation {
  std::vector<ValidationRow> rows;
  std::vector<ValidationTrace> traces;  ///< as many as ValidationOptions::traced_draws asks for
  Eigen::Index measured_nodes = 0;      ///< 0: a reduced model was the truth
  std::string unmoved_directions;       ///< AxisReach::unmoved_directions() at the first check point
  /// For each draw the reduction of the RMS over all check points, percent.
  std::vector<double> reductions(const std::string& load, With with) const;
  /// The same in the directions that linear axes move.
  std::vector<double> moved_reductions(const std::string& load, With with) const;
  /// RMS over all machines and check points of a load. @param value  a member of ValidationRow
  double rms(const std::string& load, double ValidationRow::*value) const;
  /// What stays in directions that no linear axis moves, and the reduction in the others; empty: all are moved.
  std::string unmoved_sentence(const std::string& load, const std::string& unit = "um") const;
  /// For each draw how much of what the model leaves without sensors (told) the observer takes away, percent, in the
  /// directions that linear axes move.
  std::vector<double> cuts(const std::string& load) const;
  double median_reduction(const std::string& load, bool sensors) const;
  Rows table() const;         ///< a row per load and draw; medians and 10th percentiles last
  std::string brief() const;  ///< the table as text
  Rows summary() const;       ///< medians and 10th percentiles of each load
  Validation first(int draws) const;
};

using core::quantile;

/// @throws InputError if the case has no poses at which the compensation is judged
void require_check_points(const solver::Case& machine_case);

/// The load programs of the case as each machine runs them. @throws InputError if one is unknown
std::vector<MeasuredLoad> validation_loads(const solver::Case& machine_case, const ValidationOptions& options);

/// Measures every load on every machine, the loads of a machine one after another. @return nodes of the measured mesh
/// @param take  gets each measurement  @throws InputError if the case has no check points
Eigen::Index measure_each(
    const solver::Case& machine_case, const std::vector<MeasuredLoad>& loads, const ValidationOptions& options,
    const std::function<void(int draw, const MeasuredLoad& load, const Measurement& measurement)>& take);

/// @throws InputError if the case has no check points or a load is unknown
Validation validate_online(const solver::Case& machine_case, const reduction::ReducedModel& model,
                           const ValidationOptions& options);

/// Runs the compensator along a measurement: error of the TCP left at each displacement pose.
/// Rows of RMS for one measured load. @param traces  if given: gets the errors over time
std::vector<ValidationRow> judge_compensation(const Measurement& measurement, const mesh::Machine& machine,
                                              const reduction::ReducedModel& model, const std::string& load, int draw,
                                              std::vector<ValidationTrace>* traces = nullptr);

namespace detail {
/// (3 x rows) of each pose at which dx, dy and dz were measured, um; its poses are appended.
std::vector<Eigen::Matrix3Xd> measured_translations(const Measurement& measurement, const mesh::Machine& machine,
                                                    std::vector<mesh::Pose>& poses);
}  // namespace detail

}  // namespace thermotwin::compensation
