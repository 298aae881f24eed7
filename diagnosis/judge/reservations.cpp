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
#include "diagnosis/response/start_modes.h"

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

/// "spindle", "axis.X"
std::string motion_of(const std::string& channel) { return channel.substr(0, channel.rfind('.')); }

bool follows(const mesh::SourceSpec& source, const MissingSource& missing) {
  std::set<std::string> motions{motion_of(missing.follows)};
  for (const std::string& channel : missing.alike) motions.insert(motion_of(channel));
  return motions.contains(source.drive) ||
         std::any_of(source.laws.begin(), source.laws.end(),
                     [&](const mesh::PowerLaw& law) { return motions.contains(motion_of(law.input)); }) ||
         std::any_of(source.losses.begin(), source.losses.end(), [&](const mesh::LossLaw& loss) {
           return motions.contains(loss.motion) || motions.contains("axis." + loss.motion);
         });
}

/// Whether a stated source and a missing one follow the same motion and enter the same body.
bool is_one_heat(const mesh::Machine& machine, const Parameter& stated, const Parameter& missing) {
  if (stated.missing || row_of(stated.kind).target != Target::source) return false;
  const auto source = std::find_if(machine.sources.begin(), machine.sources.end(),
                                   [&](const mesh::SourceSpec& own) { return own.id == stated.where; });
  return source != machine.sources.end() && heats(machine, *source, missing.missing->body) &&
         follows(*source, *missing.missing);
}

}  // namespace

bool heats(const mesh::Machine& machine, const mesh::SourceSpec& source, const std::string& body) {
  const auto lies_on = [&](const std::string& surface) {
    return std::any_of(machine.surfaces.begin(), machine.surfaces.end(),
                       [&](const mesh::SurfaceSpec& own) { return own.id == surface && own.body == body; });
  };
  const auto touches = [&](const std::string& joint) {
    return std::any_of(machine.joints.begin(), machine.joints.end(), [&](const mesh::JointSpec& own) {
      return own.id == joint && (lies_on(own.slave) || lies_on(own.master));
    });
  };
  return std::any_of(source.places.begin(), source.places.end(),
                     [&](const mesh::SourcePlace& place) { return lies_on(place.surface) || touches(place.joint); });
}

void leave_one_heat_open(const mesh::Machine& machine, Diagnosis& out) {
  const bool strained = out.verdict == Verdict::ambiguous && !out.strained.empty();
  if (!strained && (out.verdict != Verdict::explained || out.causes.size() != 2)) return;
  std::vector<RankedCause> open = out.causes;
  open.insert(open.end(), out.ambiguous_set.begin(), out.ambiguous_set.end());
  const auto missing =
      std::find_if(open.begin(), open.end(), [](const RankedCause& cause) { return cause.parameter.missing; });
  if (missing == open.end()) return;
  const auto is_same = [&](const RankedCause& cause) {
    return is_one_heat(machine, cause.parameter, missing->parameter);
  };
  const auto in_ranking = std::find_if(out.ranking.begin(), out.ranking.end(), [&](const RankedCause& cause) {
    return cause.log_evidence >= strong && is_same(cause);
  });
  const bool named = std::any_of(open.begin(), open.end(), is_same);
  if (!named && (!strained || in_ranking == out.ranking.end())) return;
  if (!named) out.ambiguous_set.insert(out.ambiguous_set.begin(), *in_ranking);
  const RankedCause& same = named ? *std::find_if(open.begin(), open.end(), is_same) : *in_ranking;
  const MissingSource& heat = *missing->parameter.missing;
  out.one_heat = fmt::format(
      "the missing source may be heat of {} that enters at another place than the model assumes: both enter {} and "
      "follow {}",
      same.parameter.where, heat.body, heat.follows);
  if (!strained) leave_open(out.one_heat, out);
  const auto stated = std::find_if(out.ambiguous_set.begin(), out.ambiguous_set.end(), is_same);
  if (out.causes.front().parameter.missing && stated != out.ambiguous_set.end()) {
    std::swap(out.causes.front(), *stated);
    std::rotate(out.ambiguous_set.begin(), stated, std::next(stated));
  }
}

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

std::string perhaps_steady_heat(const Observations& record, const Diagnosis& diagnosis) {
  if (!begins_warm(record)) return "";
  for (const RankedCause& cause : diagnosis.causes) {
    if (cause.parameter.kind == Kind::sensor_offset)
      return fmt::format(
          "the machine was at work when the record began, and steady heat near {} that had begun before looks like an "
          "offset of this sensor (a record that begins in equilibrium decides)",
          cause.parameter.where);
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
