// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a diagnosis says.

#include <string>
#include <vector>

#include "core/table.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/judge/verdict.h"

namespace thermotwin::diagnosis {

struct ChannelResidual {
  std::string id, unit;
  double uncertainty = 0, rms_before = 0, rms_after = 0;
  double explained_std = 0;  ///< expected residual from nominal uncertainty, mesh and noise
  double p_value_white = 0;
};

/// What a channel's residual without a cause shows, on the whole record.
struct ResidualAnalysis {
  std::string id;
  double ratio = 0;           ///< RMS over what is expected
  double mean = 0, peak = 0;  ///< in the channel's unit
  double peak_time_s = 0;
  double memory_s = 0;  ///< time by which it forgets itself
  std::string follows;  ///< input that it follows most; empty: none well
  double delay_s = 0, correlation = 0;
};

struct RankedCause {
  Parameter parameter;
  double probability = 0, log_evidence = 0;  ///< against none, natural logarithm; of none 0
  double value = 0, std = 0;                 ///< estimate
  double heldout_explained_percent =
      0;               ///< of the residual's mean square, held-out time; without a machine of its channel's RMS
  core::Table series;  ///< heat over time of a named source_missing; else empty
};

/// The measurement that tells most where something is left to decide; all empty where nothing is.
struct NextMeasurement {
  std::string load, channel, why;
  double duration_h = 0;
  std::vector<std::string> outcomes;  ///< what each cause foretells of the channel, one sentence each
};

/// From which size on the record would show a cause of a kind. Sizes are changes against nominal in the unit, of a ratio
/// in shares of the nominal value.
struct Detectable {
  Kind kind = Kind::none;
  std::string unit;
  bool ratio = false;
  double least = 0, most = 0;  ///< at the place where it is seen best, and where it is seen worst
  std::string best, worst;     ///< these places
  int invisible = 0;           ///< places whose whole prior shows nothing in this record
};

struct Diagnosis {
  Verdict verdict = Verdict::unexplained;
  std::vector<RankedCause> ranking;  ///< most probable first; none and unknown take part
  std::vector<RankedCause> causes;   ///< named ones
  std::vector<RankedCause> ambiguous_set;
  std::vector<ChannelResidual> residuals;
  std::vector<ResidualAnalysis> analysis;
  std::vector<Detectable> detectable;  ///< a row a kind; empty without a machine
  double heldout_rms_before_um = 0, heldout_rms_after_um = 0;
  double reduction_percent = 0, ci95_low_percent = 0, ci95_high_percent = 0;
  std::string sentence;              ///< the verdict in words
  std::vector<std::string> actions;  ///< where to look on the machine, and for what; the leading one first
  std::string strained;  ///< what the named causes alone would ask for that is never expected; empty: nothing
  NextMeasurement next;
  std::string measurement;    ///< name of its folder
  double heldout_from_s = 0;  ///< what comes later was judged, never fitted
  std::vector<std::string>
      warnings;  ///< what the reader has to know first: inputs that nobody recorded, an uneven start, ...
  std::vector<std::string> notes;  ///< what was left out and why, start temperature, ...
  /// Interval means: time_s, <channel>, <channel>_before, <channel>_after (measured minus predicted)
  /// and <channel>_std, what nominal uncertainty, mesh and noise explain.
  core::Table series;
  std::string extended_machine_text;  ///< empty if nothing is recommended
};

}  // namespace thermotwin::diagnosis
