// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Sets of a bank: what is hidden is drawn from a seed, measured on a specimen, diagnosed on the reduced
// model, and kept as one line. The diagnosis gets the model and the measurement and nothing else.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/record/diagnose_options.h"
#include "expectations.h"
#include "reduction/model/reduced_model.h"
#include "specimen.h"

namespace thermotwin::hidden {

enum class Group { single, clean, pair, outside, change };

/// One line of the bank's table.
struct Line {
  std::string id, group, kind, where;  ///< truth; of pairs the first
  std::string kind2, where2;
  double value = 0, nominal_std = 0;  ///< what the effect amounts to
  /// Expected 2 ln of the Bayes factor. Of an outside effect chi-square of what it does to the readings beside nominal
  /// uncertainty, and of what is left of that beside the single cause that leaves least (rival).
  double against_none = 0, against_rival = 0;
  std::string rival;
  /// A named or shared cause that is the truth has the truth's words, also a missing source whose place differs.
  diagnosis::Verdict verdict = diagnosis::Verdict::unexplained;
  std::string named_kind, named_where, set;                 ///< set: all named and shared causes
  double probability = 0, rank = 0, estimate = 0, std = 0;  ///< of the truth
  double named_probability = 0;
  double gain = absent;  ///< on held-out time, relative to that with the truth
  /// RMS of the displacements, um, before, with what was named and with the truth: on held-out time, under an
  /// unseen program at the record's poses and at unseen ones.
  double heldout_before = absent, heldout_after = absent, heldout_truth = absent;
  double program_before = absent, program_after = absent, program_truth = absent;
  double poses_before = absent, poses_after = absent, poses_truth = absent;
  /// The same with what names no cause (baselines.h), and whether the refit's largest change is the truth.
  double refit_heldout = absent, refit_program = absent, refit_right = absent;
  double process_heldout = absent, process_program = absent, sparse_heldout = absent, sparse_program = absent;
  /// Of the most probable missing source where one is hidden: mm from the truth, radius of its region.
  double place_error = absent, region = absent;
  double follows_right = absent;  ///< 1, 0
  double seconds = 0, second_named = 0;
  /// Of a missing source on a machine of 12 sensors or more: 100 mm or 6 % of the machine's diagonal.
  double place_allowed = absent;
  /// Nats by which the truth, fitted exactly, is ahead of what the diagnosis prefers, fitted alike.
  double refit_over_winner = absent;

  static constexpr double absent = -1e9;
  bool clear() const { return against_none >= 20.0 && against_rival >= 10.0; }
  bool identifiable() const { return group == "single" && clear(); }
  bool visible() const { return (group == "outside" || group == "change") && against_none >= 30.0; }
  bool unlike_any() const { return visible() && against_rival >= 30.0; }
  bool better_missed() const;  ///< a single that is not named, although its exact refit is ahead of the winner's
  std::string text() const;    ///< tab separated
  /// @param text  may end after `second_named`, as those of earlier banks do
  static Line parse(const std::string& text);
  static std::string header();
};

/// What a seed hides: of several draws the first whose effects can be told from all others, else the last.
Draw draw_set(const Specimen& specimen, Expectations& expectations, Group group, diagnosis::Kind kind,
              const std::string& load, std::uint64_t seed);

/// Kinds that the machine offers as single causes.
std::vector<diagnosis::Kind> offered_kinds(const Specimen& specimen, const std::string& load,
                                           const reduction::ReducedModel& model);

/// What a set comes with beside the measurement that the diagnosis gets; null where it stays unknown.
struct Beside {
  /// Noiseless: what an outside effect is in, and the same machine without it.
  const compensation::Measurement *affected = nullptr, *unaffected = nullptr;
  /// Measures the same machine under another program, exact; asked of identifiable singles alone.
  std::function<compensation::Measurement()> unseen;
  std::size_t measured_poses = 0;  ///< of the unseen program's: those that the record has too
  std::vector<Followable> inputs;  ///< that a missing source may follow
  double diagonal_m = 0;           ///< of the machine
  diagnosis::DiagnoseOptions how;  ///< of the diagnosis
};

/// @param effective  (truths) what each effect amounts to against the nominal machine; empty: as drawn
Line diagnose_set(const std::string& id, Group group, const Draw& draw, const compensation::Measurement& measurement,
                  const reduction::ReducedModel& model, const Beside& beside = {},
                  const std::vector<double>& effective = {});

/// The table of scores, one by kind, and detection over effect size.
std::string score(const std::vector<Line>& lines);

}  // namespace thermotwin::hidden
