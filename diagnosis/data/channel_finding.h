// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One displacement of a record without a machine: does it leave the lag model of the record's first part, which
// extension explains that, and does the extension hold in the last part, which is never fitted?

#include <string>
#include <vector>

#include "diagnosis/data/data_hypotheses.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

/// An extension on the last part.
struct OnLastPart {
  double rms = 0, explained_percent = 0;  ///< explained: of the RMS without the extension
  Interval gain;                          ///< percent
};

struct ChannelFinding {
  Eigen::Index target = 0;
  std::string channel, unit;
  WeighedChannel weighed;
  std::vector<Eigen::Index> last, later;  ///< rows with a value: of the last part, of all after the first
  double signal = 0, rms_before = 0;      ///< spread over the record; RMS of the residual in the last part
  bool discrepancy = false;               ///< the residual after the first part is not by chance
  bool untold = false;                    ///< a discrepancy as large as the signal would pass
  bool doubt = false;                     ///< no discrepancy, but that nothing changed is improbable
  std::vector<OnLastPart> last_part;      ///< of each extension
  std::size_t best = 0;                   ///< most probable extension
  std::vector<std::size_t> holding;       ///< extensions that gain on the last part and are not negligible

  bool clean() const { return !(discrepancy || untold || doubt); }
  const Extension& leading() const { return weighed.extensions[best]; }
  bool names() const;    ///< the leading extension is sure and holds in the last part
  bool open() const;     ///< neither clean nor explained nor surely off
  bool refused() const;  ///< the leading extension is sure before the last part and does not hold there
  double none() const;   ///< probability that nothing changed, as the ranking has it
  double unknown() const;
  /// RMS after the first part over the expected one.
  double strays() const { return weighed.seen / std::max(weighed.expected, 1e-12); }
  /// (n) the residual, with the leading extension in the model where it is named.
  Eigen::VectorXd after(const DataRecord& record) const;
};

/// @param signals  spread of every displacement; a still one beside others that move cannot be untold
ChannelFinding find_in_channel(const DataRecord& record, const RecordSegments& segments, Eigen::Index target,
                               const std::vector<double>& signals);

/// The extension as a cause of the channel.
RankedCause cause_of(const ChannelFinding& finding, std::size_t extension);
/// none or unknown. @param log_evidence  against none
RankedCause no_cause(Kind kind, const std::string& channel, double probability, double log_evidence = 0.0);
/// All extensions, none and unknown, most probable first. Their probabilities sum to 1.
std::vector<RankedCause> ranking_of(const ChannelFinding& finding);

/// The leading extension on the last part, and the residual in numbers.
std::vector<std::string> notes_of(const DataRecord& record, const ChannelFinding& finding);

/// The measurement that would let the next record tell: the input whose gain is least known, or a further sensor
/// where no input follows the channel.
NextMeasurement needed(const DataRecord& record, const RecordSegments& segments, const ChannelFinding& finding);

}  // namespace thermotwin::diagnosis
