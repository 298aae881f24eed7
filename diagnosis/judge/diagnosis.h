// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The result of a diagnosis.

#include <optional>
#include <string>
#include <vector>

#include "core/table.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/inference/reading_steps.h"
#include "diagnosis/judge/verdict.h"

namespace thermotwin::diagnosis {

struct ChannelResidual {
  std::string id, unit;
  int record = 0;  ///< number of its record
  double uncertainty = 0, rms_before = 0, rms_after = 0;
  double explained_std = 0;  ///< expected residual from stated uncertainty, discretisation error and noise
  double p_value_white = 0;
};

/// Properties of a channel's residual without a cause, on the whole record.
struct ResidualAnalysis {
  std::string id;
  double ratio = 0;           ///< RMS over the expected one
  double mean = 0, peak = 0;  ///< in the channel's unit
  double peak_time_s = 0;
  double memory_s = 0;  ///< correlation time
  std::string follows;  ///< input with the largest correlation; empty: none is large
  double delay_s = 0, correlation = 0;
};

/// Where a source that machine.toml does not have is to be looked for.
struct PlaceOfCause {
  Eigen::Vector3d on_skin = Eigen::Vector3d::Zero();  ///< m, home frame: the part of the body's skin nearest to it
  std::string surface;                                ///< nearest named surface of the body; empty: none is near
  double surface_m = 0;                               ///< its distance
};

struct RankedCause {
  Parameter parameter;
  double probability = 0, log_evidence = 0;  ///< against none, natural logarithm; of none 0
  double value = 0, std = 0;                 ///< estimate
  double heldout_explained_percent =
      0;               ///< share of the residual's mean square on held-out data; without a machine of its channel's RMS
  core::Table series;  ///< heat over time of a named source_missing; else empty
  std::optional<PlaceOfCause> place;  ///< of a named source_missing
};

/// The measurement that distinguishes the causes best; empty if nothing has to be decided.
struct NextMeasurement {
  std::string load, channel, why;
  double duration_h = 0;
  std::vector<std::string> outcomes;  ///< what each cause foretells of the channel, one sentence each
};

/// Steps in readings that no kind of cause describes.
struct StepsSeen {
  std::vector<std::string> channels;  ///< that have these steps, all of the same size unless there is a quantity
  std::string quantity;               ///< of several, whose sizes these are: the one that moves most
  std::string unit;                   ///< of their sizes
  std::vector<ReadingStep> steps;     ///< in the order of time; empty: there are none
  std::vector<std::string> inputs;    ///< that changed within half an hour before a step
  std::size_t record = 0;             ///< whose times these are, in the order of the data

  /// Whether there is a single one, which comes with a time constant.
  bool creeps() const { return steps.size() == 1 && steps.front().memory_s > 0.0; }
};

/// From which size on the record would show a cause of a kind. Sizes are changes against nominal in the unit, of a
/// ratio in shares of the nominal value.
struct Detectable {
  Kind kind = Kind::none;
  std::string unit;
  bool ratio = false;
  double least = 0, most = 0;  ///< at the most and at the least observable place
  std::string best, worst;     ///< these places
  int invisible = 0;           ///< places whose whole prior shows nothing in this record
};

/// One answer to what differs: no cause, one, two together, something unknown, or all others. Probabilities add to 1.
struct Explanation {
  std::string name;
  double probability = 0;
  std::optional<double> log_evidence;  ///< against none; of a sum of several there is none
};

/// One of several records of the machine, in its own time.
struct DiagnosedRecord {
  std::string name;
  double from_s = 0, to_s = 0, heldout_from_s = 0;
  double rms_before_um = 0, rms_after_um = 0;  ///< of the displacements on its held-out data; 0: it has none
  Eigen::Index first_row = 0, rows = 0;        ///< of Diagnosis::series
};

struct Diagnosis {
  Verdict verdict = Verdict::unexplained;
  std::vector<Explanation> explanations;  ///< most probable first, the others last; empty without a machine
  std::vector<RankedCause> ranking;       ///< most probable first; none and unknown take part
  std::vector<RankedCause> causes;        ///< named ones
  std::vector<RankedCause> ambiguous_set;
  std::vector<ChannelResidual> residuals;
  std::vector<ResidualAnalysis> analysis;
  StepsSeen steps;                      ///< where they describe best what is unknown
  std::vector<std::string> unknown_in;  ///< channels that something unknown is in alone; empty: others as well
  std::vector<Detectable> detectable;   ///< a row a kind; empty without a machine
  double heldout_rms_before_um = 0, heldout_rms_after_um = 0;
  double reduction_percent = 0, ci95_low_percent = 0, ci95_high_percent = 0;
  double effect_fitted_um = 0, effect_heldout_um = 0;  ///< RMS of what the causes change in the displacements
  std::string sentence;                                ///< the verdict in words
  std::vector<std::string> actions;  ///< where to look on the machine, and for what; the leading one first
  double mesh_share =
      0;  ///< of a channel's own change that the mesh hides; 0: what the mesh leaves open is no more than
          ///< the record itself does
  std::string open_because;  ///< of a cause and the machine as stated: why neither is named; empty: other reasons
  std::string nearest;       ///< beside something unknown: what comes nearest of all that is listed; empty: nothing
  std::string strained;      ///< why the named causes alone are implausible; empty: they are not
  std::string connection;    ///< channels that seem to be connected or stated otherwise, in words; empty: none
  /// The named causes foretell held-out data as well as expected beside fitted values of what else is uncertain: those
  /// values, each within its uncertainty, had hidden a part of the causes, and correcting the causes alone worsens.
  bool foretold_beside_others = false;
  std::string one_heat;  ///< why a missing source may be none: see leave_one_heat_open; empty: no reason
  NextMeasurement next;
  std::string measurement;               ///< name of its folder
  std::vector<DiagnosedRecord> records;  ///< several ones; empty: there is one
  double heldout_from_s = 0;             ///< later data are held out
  std::vector<std::string>
      warnings;  ///< for the reader's attention: unrecorded inputs, an uneven initial temperature, ...
  std::vector<std::string> notes;  ///< left-out channels and reasons, initial temperature, ...
  /// Interval means: time_s, `<channel>`, `<channel>_before`, `<channel>_after` (measured minus predicted)
  /// and `<channel>_std`, the standard deviation expected from stated uncertainty, discretisation error and noise. Of
  /// several records one below the other, each in its own time, and `record`, its number from 1.
  core::Table series;
  std::string extended_machine_text;  ///< empty if nothing is recommended
};

}  // namespace thermotwin::diagnosis
