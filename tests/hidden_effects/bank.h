// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Sets of a bank: what is hidden is drawn from a seed, measured on a specimen, diagnosed on the reduced
// model, and kept as one line. The diagnosis gets the model and the measurement and nothing else.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/problem.h"
#include "reduction/reduced_model.h"
#include "specimen.h"

namespace thermotwin::hidden {

enum class Group { single, clean, pair, outside };

/// One line of the bank's table.
struct Line {
  std::string id, group, kind, where;   ///< truth; of pairs the first
  std::string kind2, where2;
  double value = 0, nominal_std = 0;    ///< what the effect amounts to
  /// Expected 2 ln of the Bayes factor; of an outside effect chi-square of what it does to the readings.
  double against_none = 0, against_rival = 0;
  std::string rival;
  std::string verdict, named_kind, named_where, set;  ///< set: all named and shared causes
  double probability = 0, rank = 0, estimate = 0, std = 0;  ///< of the truth
  double named_probability = 0;
  double gain = 0;                      ///< on held-out time, relative to that with the truth
  double seconds = 0;
  bool second_named = false;

  bool clear() const { return against_none >= 20.0 && against_rival >= 10.0; }
  bool identifiable() const { return group == "single" && clear(); }
  bool visible() const { return group == "outside" && against_none >= 30.0; }
  std::string text() const;             ///< tab separated
  static Line parse(const std::string& text);
  static std::string header();
};

/// What a clean machine of the type shows, for choosing what can be seen.
class Expectations {
 public:
  /// Both must outlive it.
  Expectations(const Specimen& specimen, const reduction::ReducedModel& model) : specimen_(specimen), model_(model) {}
  /// The line with the factors that a truth is expected to have under a load.
  Line of(const Truth& truth, const std::string& load);

 private:
  const diagnosis::Problem& problem(const std::string& load);
  const Specimen& specimen_;
  const reduction::ReducedModel& model_;
  std::map<std::string, diagnosis::Problem> problems_;
};

/// What a seed hides: of several draws the first whose effects can be told from all others, else the last.
Draw draw_set(const Specimen& specimen, Expectations& expectations, Group group, const std::string& kind, const std::string& load,
              std::uint64_t seed);

/// Kinds that the machine offers as single causes.
std::vector<std::string> offered_kinds(const Specimen& specimen, const std::string& load);

/// @param clean      the same machine without an outside effect; null: how much it shows stays unknown
/// @param effective  what the effect amounts to against the nominal machine; absent: as drawn
Line diagnose_set(const std::string& id, Group group, const Draw& draw, const compensation::Measurement& measurement,
                  const reduction::ReducedModel& model, const compensation::Measurement* clean = nullptr,
                  std::optional<double> effective = {});

/// The table of scores, one by kind, and detection over effect size.
std::string score(const std::vector<Line>& lines);

}  // namespace thermotwin::hidden
