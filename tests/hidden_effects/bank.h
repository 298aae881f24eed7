// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Sets of a bank: what is hidden is drawn from a seed, measured on a specimen, diagnosed on the reduced
// model, and kept as one line. The diagnosis gets the model and the measurement and nothing else.

#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "specimen.h"

namespace thermotwin::hidden {

enum class Group { single, clean, pair, outside };

/// One line of the bank's table.
struct Line {
  std::string id, group, kind, where;   ///< truth; of pairs the first
  std::string kind2, where2;
  double value = 0, nominal_std = 0;
  double against_none = 0, against_rival = 0;  ///< expected 2 ln of the Bayes factor
  std::string rival;
  std::string verdict, named_kind, named_where, set;  ///< set: all named and shared causes
  double probability = 0, rank = 0, estimate = 0, std = 0;  ///< of the truth
  double named_probability = 0;
  double gain = 0;                      ///< on held-out time, relative to that with the truth
  double seconds = 0;
  bool second_named = false;

  bool identifiable() const { return group == "single" && against_none >= 20.0 && against_rival >= 10.0; }
  std::string text() const;             ///< tab separated
  static Line parse(const std::string& text);
  static std::string header();
};

/// What a seed hides. @param place  counts the sets of a kind
Draw draw_set(const Specimen& specimen, Group group, const std::string& kind, const std::string& load, std::uint64_t seed);

/// Kinds that the machine offers as single causes.
std::vector<std::string> offered_kinds(const Specimen& specimen, const std::string& load);

Line diagnose_set(const std::string& id, Group group, const Draw& draw, const compensation::Measurement& measurement,
                  const reduction::ReducedModel& model);

/// The table of scores, one by kind, and detection over effect size.
std::string score(const std::vector<Line>& lines);

}  // namespace thermotwin::hidden
