// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/plan/test_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/range.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/plan/load_intervals.h"
#include "metrology/plan/sphere.h"
#include "metrology/plan/test_places.h"
#include "solver/elastic/outputs.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::metrology {

namespace units = core::units;
using core::InputError;
using Eigen::Index;
using Eigen::Vector3d;
using mesh::Axis;
using mesh::AxisKind;
using mesh::Machine;
using mesh::Pose;

bool TestPlan::is_rtest() const {
  return options.kind != TestKind::etve && options.kind != TestKind::spindle && options.kind != TestKind::linear_axis &&
         options.kind != TestKind::rotary_axis && options.kind != TestKind::volumetric_grid;
}

namespace {

constexpr double longest_chord = units::deg;  ///< of the poses along an arc

class Planner {
public:
  Planner(const Machine& machine, const PlanOptions& options)
      : machine_(machine),
        options_(options),
        place_("plan " + test_kinds()[static_cast<std::size_t>(options.kind)]),
        rest_(mesh::parse_pose(machine, options.pose, place_ + " --pose")),
        places_(test_places(machine, options, rest_, place_)),
        plan_{options, places_.axis < 0 ? "" : machine.axes[places_.axis].id, Timeline(machine, rest_, place_), {}} {
    if (places_.on_sphere) sphere_ = places_.spheres.front();
    choose_loads();
  }

  TestPlan make() {
    measure();
    const double interval = options_.interval_min * units::minute;
    const auto intervals = [&](double hours) { return std::lround(hours * units::hour / interval); };
    RandomLoads random(limits_, options_.change_percent / 100.0, options_.standstills, options_.seed);
    const bool draws = options_.kind == TestKind::random_cycle;
    const long warm = intervals(options_.warm_up_h), cool = intervals(options_.cool_down_h);
    for (long i = 0; i < warm + cool; ++i) {
      const bool loaded = i < warm;
      std::vector<LoadMotion> loads = draws && loaded ? random.next() : loads_;
      if (!loaded)
        for (LoadMotion& load : loads) load.speed = 0.0;
      if (!loaded) std::erase_if(loads, [](const LoadMotion& load) { return load.axis >= 0; });
      add_load_interval(machine_, plan_.timeline, loads, interval,
                        fmt::format("{} {}", loaded ? "load" : "standstill", i + 1));
      measure();
    }
    return std::move(plan_);
  }

private:
  /// SI value of one unit in which the load's speed is stated; of the spindle 1.
  double speed_unit(int axis) const {
    if (axis < 0) return 1.0;
    const Axis& of = machine_.axes[axis];
    return of.kind == AxisKind::linear ? units::mm_min : of.endless ? units::rpm : units::deg_min;
  }

  LoadMotion load_of(const std::string& id) const {
    LoadMotion load;
    if (id == "spindle") {
      load.speed = options_.speed > 0 ? options_.speed : 0.5 * machine_.spindle_max_rpm;
      if (!(load.speed > 0)) throw InputError(place_ + " --speed", "absent", "a speed: the machine states no largest");
      return load;
    }
    load.axis = axis_named(machine_, id, place_ + " --load");
    const double unit = speed_unit(load.axis);
    load.speed = options_.speed > 0 ? options_.speed * unit : 0.5 * plan_.timeline.fastest(load.axis);
    if (load.speed > plan_.timeline.fastest(load.axis) * (1 + 1e-9)) {
      throw InputError(
          place_ + " --speed", fmt::format("{:.6g}", options_.speed),
          fmt::format("at most the rapid of axis {}, {:.6g}", id, plan_.timeline.fastest(load.axis) / unit));
    }
    if (!machine_.axes[load.axis].endless) std::tie(load.low, load.high) = load_range(machine_, load.axis, options_);
    return load;
  }

  void choose_loads() {
    std::vector<std::string> ids = options_.loads;
    if (options_.kind == TestKind::etve) {
      if (!ids.empty()) throw InputError(place_ + " --load", core::join(ids), "no load: the machine stands");
      return;
    }
    if (ids.empty() && options_.kind == TestKind::volumetric_grid) return;
    if (ids.empty()) ids = {options_.kind == TestKind::spindle ? "spindle" : plan_.tested};
    for (const std::string& id : ids) {
      const LoadMotion load = load_of(id);
      RandomLoads::Limits limit{load, 0.0, load.speed};
      if (options_.speeds.size() == 2) {
        const double to_si = speed_unit(load.axis);
        limit = {load, options_.speeds[0] * to_si, options_.speeds[1] * to_si};
        const double most = load.axis < 0 ? machine_.spindle_max_rpm : plan_.timeline.fastest(load.axis);
        if (limit.highest > most * (1 + 1e-9)) {
          throw InputError(place_ + " --speeds", fmt::format("{:.6g}", options_.speeds[1]),
                           fmt::format("at most {:.6g} of {}", most / to_si, id));
        }
      }
      loads_.push_back(load);
      limits_.push_back(limit);
    }
  }

  Pose lifted(const Pose& pose, const Vector3d& sphere) const {
    const Vector3d up = solver::growth_axis(machine_).second;
    return pose_on_sphere(machine_, pose, sphere + options_.clearance_mm * units::mm * up, place_);
  }

  /// Endless axes go on in their sense: the same place a turn further.
  Pose onward(Pose target) const {
    for (Index i = 0; i < target.size(); ++i) {
      if (!machine_.axes[i].endless) continue;
      const double turn = 2.0 * std::numbers::pi, now = plan_.timeline.pose()[i];
      target[i] += turn * std::ceil((now - target[i]) / turn - 1e-9);
    }
    return target;
  }

  void measure() {
    Timeline& timeline = plan_.timeline;
    ++cycle_;
    timeline.begin_stage(fmt::format("measurement {}", cycle_), cycle_);
    timeline.spindle(0.0);
    if (options_.kind == TestKind::rtest_continuous) {
      sweep();
    } else {
      for (int k = 0; k < std::ssize(places_.poses); ++k) measure_point(k);
    }
    timeline.rapid(onward(rest_), "rest");
  }

  void measure_point(int k) {
    Timeline& timeline = plan_.timeline;
    const bool on_sphere = places_.on_sphere;
    const Vector3d sphere = on_sphere ? places_.spheres[k] : Vector3d::Zero();
    const Pose target = onward(places_.poses[k]);
    if (on_sphere) timeline.rapid(lifted(target, sphere));
    const std::string says = fmt::format("cycle {} place {}", cycle_, k + 1);
    if (on_sphere) {
      timeline.feed(target, options_.feed_mm_min * units::mm_min, options_.feed_deg_min * units::deg_min);
    } else {
      timeline.rapid(target);
    }
    const double start = timeline.now();
    timeline.dwell(options_.record_s, "record " + says);
    const Vector3d nominal = on_sphere ? sphere_at(machine_, target, sphere) : solver::tcp_position(machine_, target);
    plan_.points.push_back({start + 0.5 * options_.record_s, cycle_, k + 1, timeline.pose(), nominal});
    if (on_sphere)
      timeline.feed(lifted(target, sphere), options_.feed_mm_min * units::mm_min,
                    options_.feed_deg_min * units::deg_min);
  }

  /// To the end of the arc and back at one speed, with a standstill at each end (Gebhardt 2014, 4.1.2).
  void sweep() {
    Timeline& timeline = plan_.timeline;
    const Pose first = onward(places_.poses[0]);
    timeline.rapid(lifted(first, sphere_));
    timeline.feed(first, options_.feed_mm_min * units::mm_min, options_.feed_deg_min * units::deg_min);
    sweeps_start_ = plan_.points.size();
    const double span = places_.poses[1][places_.axis] - places_.poses[0][places_.axis];
    for (const double way : {span, -span}) {
      timeline.dwell(options_.record_s, "standstill");
      sweep_once(way);
    }
    timeline.dwell(options_.record_s, "standstill");
    timeline.feed(lifted(timeline.pose(), sphere_), options_.feed_mm_min * units::mm_min,
                  options_.feed_deg_min * units::deg_min);
  }

  Pose turned_by(const Pose& from, double angle) const {
    Pose rotary = from;
    rotary[places_.axis] += angle;
    return pose_on_sphere(machine_, rotary, sphere_, place_);
  }

  void sweep_once(double span) {
    Timeline& timeline = plan_.timeline;
    const Pose from = timeline.pose();
    const double speed = options_.feed_deg_min * units::deg_min;
    const int chords = std::max(1, static_cast<int>(std::ceil(std::abs(span) / longest_chord)));
    std::vector<Pose> way;
    for (int i = 1; i <= chords; ++i) way.push_back(turned_by(from, span * i / chords));
    const double start = timeline.now(), duration = std::abs(span) / speed;
    const auto [words, radius] = arc_words(from, way.back(), span);
    timeline.arc(places_.axis, way, speed, words, radius * speed / units::mm_min,
                 fmt::format("record cycle {} at {:.6g} deg/min", cycle_, options_.feed_deg_min));
    const std::size_t before = sweeps_start_;
    const long samples = std::lround(std::floor(duration * options_.rate_Hz + 1e-9));
    for (long i = 0; i <= samples; ++i) {
      const double done = i, share = samples > 0 ? done / samples : 0.0;
      const Pose at = turned_by(from, span * share);
      const int place = plan_.points.size() - before + 1;
      plan_.points.push_back({start + duration * share, cycle_, place, at, sphere_at(machine_, at, sphere_)});
    }
  }

  /// Body on which the tested axis stands.
  Eigen::Isometry3d carrier(const Pose& pose) const {
    int body = machine_.body_index(machine_.tcp.table_body);
    while (machine_.bodies[body].axis != plan_.tested) body = machine_.body_index(machine_.bodies[body].parent);
    const int parent = machine_.body_index(machine_.bodies[body].parent);
    return parent < 0 ? Eigen::Isometry3d::Identity() : mesh::body_transform(machine_, parent, pose);
  }

  /// A circular block in a plane of G17 to G19; the rotary axis goes along linearly.
  /// @return the words without the feed, and the radius in m
  std::pair<std::string, double> arc_words(const Pose& from, const Pose& to, double span) const {
    const Axis& axis = machine_.axes[places_.axis];
    const Eigen::Isometry3d stands = carrier(from);
    const Vector3d direction = stands.linear() * axis.direction;
    Index along = 0;
    if (direction.cwiseAbs().maxCoeff(&along) < 1.0 - 1e-9)
      throw InputError(place_ + " --pose", options_.pose, "a pose at which axis " + axis.id + " lies along X, Y or Z");
    const Vector3d way = sphere_at(machine_, from, sphere_) - stands * axis.origin;
    const Vector3d radius = way - direction * direction.dot(way);
    const bool positive = span * direction[along] > 0;
    std::string words = fmt::format("G{} G0{}", along == 2 ? 17 : along == 1 ? 18 : 19, positive ? 3 : 2), centre;
    for (int i = 0; i < 3; ++i) {
      const int index = machine_.axis_index(std::string(1, "XYZ"[i]));
      if (index < 0 || (machine_.axes[index].direction - Vector3d::Unit(i)).norm() > 1e-9) {
        throw InputError(place_ + " --axis", "'" + plan_.tested + "'",
                         "a machine whose axes X, Y and Z carry the tool, for circular blocks");
      }
      if (i == along) continue;
      words += fmt::format(" {}{:.6f}", "XYZ"[i], to[index] / units::mm);
      centre += fmt::format(" {}{:.6f}", "IJK"[i], -radius[i] / units::mm);
    }
    words += centre + fmt::format(" {}{:.6f}", axis.id, to[places_.axis] / units::deg);
    return {words, radius.norm()};
  }

  const Machine& machine_;
  const PlanOptions& options_;
  std::string place_;
  Pose rest_;
  TestPlaces places_;
  TestPlan plan_;
  int cycle_ = 0;
  Vector3d sphere_ = Vector3d::Zero();  ///< of a continuous test
  std::size_t sweeps_start_ = 0;        ///< points before the cycle
  std::vector<LoadMotion> loads_;
  std::vector<RandomLoads::Limits> limits_;
};

}  // namespace

TestPlan make_plan(const Machine& machine, const PlanOptions& options) {
  options.validate();
  if (!machine.has_tcp())
    throw InputError(machine.path.string() + " [tcp]", "missing", "a [tcp]: a test measures its error");
  return Planner(machine, options).make();
}

}  // namespace thermotwin::metrology
