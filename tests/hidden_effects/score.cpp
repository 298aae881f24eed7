// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bank.h"
#include "baselines.h"

namespace thermotwin::hidden {

using diagnosis::Kind;

namespace {

struct Share {
  int hit = 0, of = 0;
  void count(bool yes) { hit += yes, ++of; }
  std::string text() const { return of == 0 ? "-" : fmt::format("{:.1f} % ({} of {})", 100.0 * hit / of, hit, of); }
};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

bool in_set(const Line& line, const std::string& kind, const std::string& where) {
  return ("; " + line.set + ";").find("; " + kind + " " + where + ";") != std::string::npos;
}

/// Gains relative to those with the truth, where the truth itself gains something.
struct Relative {
  std::vector<double> values;
  Share negative;

  void add(double before, double after, double truth) {
    if (before == Line::absent || before - truth < std::max(0.1, 0.05 * before)) return;
    values.push_back((before - after) / (before - truth));
    negative.count(after > before);
  }
  std::string text() const {
    return values.empty() ? "-" : fmt::format("{:.2f} ({} sets)", median(values), values.size());
  }
};

/// A cause is said for sure.
bool sure(const Line& line) {
  return line.verdict == diagnosis::Verdict::explained ||
         (line.verdict == diagnosis::Verdict::ambiguous && line.named_probability > 0.9);
}

/// The first one named is one of what is hidden.
bool named_is_true(const Line& line) {
  return (line.named_kind == line.kind && line.named_where == line.where) ||
         (line.named_kind == line.kind2 && line.named_where == line.where2);
}

/// What no kind describes is told: as something unknown, as one of several, or as a law or step of its place.
bool told(const Line& line) {
  if (line.verdict == diagnosis::Verdict::unexplained || line.verdict == diagnosis::Verdict::ambiguous) return true;
  const bool of_place = line.named_kind == name_of(Kind::other_law) || line.named_kind == name_of(Kind::source_step) ||
                        line.named_kind == name_of(Kind::contact_step);
  return line.verdict == diagnosis::Verdict::explained && of_place && line.named_where == line.where;
}

/// The first one named is the truth: explained, or sure beside a second cause that is not.
bool named(const Line& line) {
  const bool sure = line.verdict == diagnosis::Verdict::explained ||
                    (line.verdict == diagnosis::Verdict::ambiguous && line.named_probability >= 0.9);
  return sure && line.named_kind == line.kind && line.named_where == line.where;
}

}  // namespace

bool Line::better_missed() const { return group == "single" && !named(*this) && refit_over_winner > 0.0; }

std::string score(const std::vector<Line>& lines) {
  Share identifiable, first, other, third, alarms, outside, unlike_any, both, clear_both, covered, negative;
  Share explained, in_words, better_missed, wrong, changes, near_of_twelve;
  double probability = 0.0;
  std::vector<double> gains, seconds, place_errors;
  Share near, region_holds, follows_right;
  Relative program, poses;
  struct Method {
    Relative heldout, program;
  };
  Method diagnosis, refit, process, sparse;
  Share refit_right;
  struct Bin {
    double claimed = 0;
    int right = 0, of = 0;
  };
  std::vector<Bin> bins(10);
  std::map<std::string, std::pair<Share, Share>> by_kind;  // identifiable, first named right
  std::map<int, Share> by_size;                            // log2 of the expected factor
  std::map<std::string, int> outside_verdicts;
  int unseen = 0;
  for (const Line& line : lines) {
    seconds.push_back(line.seconds);
    if (line.group == "clean") alarms.count(line.verdict != diagnosis::Verdict::no_discrepancy);
    if (line.group == "outside") {
      if (line.visible()) {
        outside.count(told(line));
        ++outside_verdicts[diagnosis::name_of(line.verdict)];
        if (line.unlike_any()) {
          unlike_any.count(told(line));
        }
      } else {
        ++unseen;
      }
    }
    if (line.group == "change" && line.visible()) changes.count(told(line));
    const bool has_truth = line.group == "single" || line.group == "pair" || line.group == "clean";
    if (has_truth) wrong.count(sure(line) && !line.named_kind.empty() && !named_is_true(line));
    if (line.group == "pair") {
      const bool found = in_set(line, line.kind, line.where) && line.second_named;
      both.count(found);
      if (line.clear()) clear_both.count(found);
    }
    if (has_truth && line.verdict != diagnosis::Verdict::no_discrepancy && !line.named_kind.empty()) {
      Bin& bin = bins[static_cast<std::size_t>(std::clamp(static_cast<int>(10.0 * line.named_probability), 0, 9))];
      bin.claimed += line.named_probability;
      bin.right += named_is_true(line);
      ++bin.of;
    }
    if (line.group != "single") continue;
    identifiable.count(line.identifiable());
    by_kind[line.kind].first.count(line.identifiable());
    by_size[static_cast<int>(std::floor(std::log2(std::max(line.against_none, 1.0))))].count(named(line));
    if (line.identifiable()) {
      first.count(named(line));
      explained.count(line.verdict == diagnosis::Verdict::explained);
      better_missed.count(line.better_missed());
      in_words.count(named(line) || in_set(line, line.kind, line.where));
      by_kind[line.kind].second.count(named(line));
      probability += line.probability;
      third.count(line.rank > 0 && line.rank <= 3);
      if (line.rank > 0) covered.count(std::abs(line.estimate - line.value) <= 1.96 * line.std);
      if (line.verdict == diagnosis::Verdict::explained) {
        if (line.gain != Line::absent) gains.push_back(line.gain), negative.count(line.gain < 0.0);
        program.add(line.program_before, line.program_after, line.program_truth);
        poses.add(line.poses_before, line.poses_after, line.poses_truth);
      }
      // All identifiable sets, also those that nothing was named for.
      const auto compare = [&](Method& method, double heldout_um, double program_um) {
        method.heldout.add(line.heldout_before, heldout_um, line.heldout_truth);
        method.program.add(line.program_before, program_um, line.program_truth);
      };
      compare(diagnosis, line.heldout_after, line.program_after);
      compare(refit, line.refit_heldout, line.refit_program);
      compare(process, line.process_heldout, line.process_program);
      compare(sparse, line.sparse_heldout, line.sparse_program);
      const auto is_refitted = [&](Kind kind) { return name_of(kind) == line.kind; };
      if (line.refit_right != Line::absent &&
          std::any_of(std::begin(refitted_kinds), std::end(refitted_kinds), is_refitted))
        refit_right.count(line.refit_right > 0.5);
      if (line.kind == name_of(Kind::source_missing) && line.named_kind == line.kind) {
        place_errors.push_back(line.place_error);
        near.count(line.place_error <= 100.0);
        if (line.place_allowed != Line::absent) near_of_twelve.count(line.place_error <= line.place_allowed);
        region_holds.count(line.place_error <= line.region);
        follows_right.count(line.follows_right > 0.5);
      }
    } else {
      other.count(line.verdict == diagnosis::Verdict::no_discrepancy || named(line) ||
                  (line.verdict == diagnosis::Verdict::ambiguous && in_set(line, line.kind, line.where)));
    }
  }
  double calibration = 0.0, verdicts = 0.0;
  for (const Bin& bin : bins) verdicts += bin.of;
  for (const Bin& bin : bins)
    if (bin.of > 0) calibration += std::abs(bin.claimed - bin.right) / std::max(verdicts, 1.0);
  std::string text = "| measure | to reach | here |\n|---|---|---|\n";
  const auto row = [&](const char* measure, const char* aim, const std::string& value) {
    text += fmt::format("| {} | {} | {} |\n", measure, aim, value);
  };
  row("identifiable sets, share of singles", ">= 60 %", identifiable.text());
  row("first named cause right (kind and place), identifiable", ">= 95 %", first.text());
  row("`explained`, identifiable", ">= 80 %", explained.text());
  row("truth named or in the set, identifiable", "-", in_words.text());
  row("missed although an exact refit of the truth is ahead of the winner, identifiable", "0", better_missed.text());
  row("wrong name with a probability above 0.9, of singles, pairs and clean sets", "<= 1 %", wrong.text());
  row("other sets: no_discrepancy, or the truth named or in the set", ">= 90 %", other.text());
  row("mean probability given to the truth, identifiable", ">= 0.85",
      first.of > 0 ? fmt::format("{:.2f}", probability / first.of) : "-");
  row("expected calibration error", "<= 0.05", fmt::format("{:.3f} ({:.0f} verdicts)", calibration, verdicts));
  row("truth within the first three, identifiable", ">= 99 %", third.text());
  row("false alarms on clean sets", "0 of 200", alarms.text());
  row("visible outside effects unexplained, ambiguous, or a law or step of the right place", ">= 85 %", outside.text());
  row("the same where every single cause leaves some of it", "-", unlike_any.text());
  row("visible changes in time, told in the same way", "-", changes.text());
  row("both of two causes named", ">= 85 %", both.text());
  row("the same where each can be told beside the other", "-", clear_both.text());
  row("95 % interval holds the truth, identifiable", "90-98 %", covered.text());
  row("gain on held-out time relative to the truth's, median", ">= 0.9",
      gains.empty() ? "-" : fmt::format("{:.2f}", median(gains)));
  row("such gains that are negative", "<= 1 %", negative.text());
  row("gain on an unseen program relative to the truth's, median", ">= 0.9", program.text());
  row("such gains that are negative", "<= 1 %", program.negative.text());
  row("the same at unseen poses, median", ">= 0.9", poses.text());
  row("such gains that are negative", "<= 1 %", poses.negative.text());
  row("place of a named missing source, median error", "-",
      place_errors.empty() ? "-" : fmt::format("{:.0f} mm", median(place_errors)));
  row("place within 100 mm", ">= 80 %", near.text());
  row("place within 100 mm or 6 % of the diagonal, 12 sensors or more", ">= 50 %", near_of_twelve.text());
  row("its region of 95 % holds the truth", "90-98 %", region_holds.text());
  row("the input it follows is right", ">= 90 %", follows_right.text());
  row("seconds of a diagnosis, median", "-", fmt::format("{:.1f}", median(seconds)));
  if (!diagnosis.heldout.values.empty() || !diagnosis.program.values.empty()) {
    text +=
        "\n| method, all identifiable sets | gain on held-out time | negative | gain on an unseen program | negative "
        "|\n|---|---|---|---|---|\n";
    const auto method = [&](const char* name, const Method& m) {
      text += fmt::format("| {} | {} | {} | {} | {} |\n", name, m.heldout.text(), m.heldout.negative.text(),
                          m.program.text(), m.program.negative.text());
    };
    method("diagnosis", diagnosis);
    method("refit of all nominal values", refit);
    method("Gaussian process of what is left", process);
    method("sparse regression of what is left", sparse);
    text += fmt::format("\nThe refit's largest change is the truth, where the truth is one of its kinds: {}\n",
                        refit_right.text());
  }
  text += "\n| kind | identifiable | first named right |\n|---|---|---|\n";
  for (const auto& [kind, shares] : by_kind)
    text += fmt::format("| {} | {} | {} |\n", kind, shares.first.text(), shares.second.text());
  text += "\n| expected 2 ln Bayes factor against none | named right |\n|---|---|\n";
  for (const auto& [size, share] : by_size)
    text += fmt::format("| {:.0f} to {:.0f} | {} |\n", std::exp2(size), std::exp2(size + 1), share.text());
  text += fmt::format("\noutside effects: {} show less than chi-square 30;", unseen);
  for (const auto& [verdict, count] : outside_verdicts) text += fmt::format(" {} {},", count, verdict);
  if (text.ends_with(',')) text.back() = '\n';
  return text;
}

}  // namespace thermotwin::hidden
