// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/reservations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/text.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/ranking.h"

namespace thermotwin::diagnosis {

namespace {

/// Sizes that wander by 15 %, and others at 2.5 stated deviations, asked for 1.7 and 3.1 at most; laws of another kind
/// for 2.4 to 6 and 4 to 4.4.
constexpr double most_freedom = 2.5, most_other = 3.5;

/// A film that transfers no heat at all: air and coolant always take some, so that it stands for something else. A
/// source or a flow may be off.
bool is_no_film(const RankedCause& cause) {
  constexpr double least_film = 0.03;
  return (cause.parameter.kind == Kind::film_coefficient || cause.parameter.kind == Kind::coolant_coupling) &&
         cause.value <= least_film;
}

/// One source or joint whose size or distribution has to change in the course of the record: lubricant that thins, a
/// step in friction, preload that is lost.
void add_other_law(Diagnosis& out) {
  const RankedCause& leading = out.causes.front();
  const Target target = row_of(leading.parameter.kind).target;
  if (leading.parameter.missing || (target != Target::source && target != Target::joint)) return;
  RankedCause law = no_parameter(Kind::other_law, leading.probability, leading.log_evidence);
  law.parameter.where = leading.parameter.where;
  out.ambiguous_set.insert(out.ambiguous_set.begin(), std::move(law));
}

}  // namespace

void leave_open(const Problem& problem, const Strain& strain, Diagnosis& out) {
  if (out.verdict != Verdict::explained) return;
  const bool alone = out.causes.size() == 1;
  if (strain.freedom > most_freedom) {
    out.strained = fmt::format(
        "its size, heat distribution or lag would have to deviate {:.1f} times as far as expected", strain.freedom);
  } else if (strain.other > most_other) {
    const Parameter& other = problem.parameters[strain.which];
    out.strained = fmt::format("{} would have to deviate by {:.1f} stated standard deviations as well", name_of(other),
                               strain.other);
  }
  if (out.strained.empty()) return;
  leave_open(out.strained, out);
  if (alone && strain.freedom > most_freedom) add_other_law(out);
}

void leave_open(const std::string& reason, Diagnosis& out) {
  out.strained = reason;
  out.verdict = Verdict::ambiguous;
  // What two are strained to explain may be the stronger one and no second.
  std::stable_sort(out.causes.begin(), out.causes.end(),
                   [](const RankedCause& a, const RankedCause& b) { return a.log_evidence > b.log_evidence; });
  out.ambiguous_set.assign(std::next(out.causes.begin()), out.causes.end());
  RankedCause unknown = no_parameter(Kind::unknown, 0.0, 0.0);
  for (const RankedCause& cause : out.ranking)
    if (cause.parameter.kind == Kind::unknown) unknown = cause;
  out.ambiguous_set.push_back(unknown);
  out.causes.resize(1);
}

std::string uncertain_size(const Diagnosis& d) {
  for (const RankedCause& cause : d.causes) {
    const double off = cause.value - cause.parameter.nominal;
    if (std::abs(off) > certain * cause.std) continue;
    const std::string unit = cause.parameter.unit == "1" ? "" : " " + cause.parameter.unit;
    return fmt::format("the {} of {} deviates by {}{} from nominal, less than two of its standard deviations of {}{}",
                       cause.parameter.name, name_of(cause.parameter), core::plain_number(off, 3), unit,
                       core::plain_number(cause.std, 2), unit);
  }
  return "";
}

std::string at_bound(const Diagnosis& d, const std::set<std::string>& switched) {
  for (const RankedCause& cause : d.causes) {
    const Parameter& p = cause.parameter;
    if (is_no_film(cause) && switched.count(p.where) == 0)
      return fmt::format("the {} of {} is almost 0, {:.2g}, and some heat always passes there", p.name, name_of(p),
                         cause.value);
    if (!is_at_bound(cause)) continue;
    return fmt::format("the {} of {} is the largest that is looked for, {:.3g}", p.name, name_of(p), p.high);
  }
  return "";
}

bool only_unknown_shares(const Diagnosis& d) {
  const auto nameless = [](const RankedCause& cause) {
    return cause.parameter.kind == Kind::unknown || cause.parameter.kind == Kind::other_law;
  };
  return d.verdict == Verdict::ambiguous && !d.ambiguous_set.empty() &&
         std::all_of(d.ambiguous_set.begin(), d.ambiguous_set.end(), nameless);
}

}  // namespace thermotwin::diagnosis
