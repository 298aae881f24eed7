// SPDX-License-Identifier: GPL-3.0-or-later
// What can only be checked once the whole of machine.toml was read.

#include "mesh/machine/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "core/progress.h"
#include "core/text.h"
#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

using core::InputError;

namespace {

/// Channels of docs/reference/machine_channels.md that this machine has.
std::vector<std::string> channels(const Machine& machine) {
  std::vector<std::string> names = {"spindle.speed_rpm", "cutting_fluid.on", "machine.on", time_of_day};
  for (const Axis& axis : machine.axes) {
    const std::string unit = axis.kind == AxisKind::linear ? "mm" : "deg";
    for (const std::string& quantity : {"position_" + unit, "feed_" + unit + "_min", "low_" + unit, "high_" + unit})
      names.push_back("axis." + axis.id + "." + quantity);
    if (machine.has_clamp(axis.id)) names.push_back("axis." + axis.id + ".clamp.on");
    if (machine.has_direction(axis.id)) names.push_back("axis." + axis.id + ".positive.on");
  }
  for (const AmbientSpec& ambient : machine.ambients) {
    names.push_back(ambient.id + ".T_C");
    if (ambient.has_gradient) names.push_back(ambient.id + ".gradient_K_m");
  }
  for (const VolumeSpec& volume : machine.volumes) names.push_back(volume.id + ".T_C");
  for (const std::string& door : machine.doors) names.push_back("door." + door + ".open");
  for (const CoolantSpec& coolant : machine.coolants) {
    names.push_back("coolant." + coolant.id + ".on");
    names.push_back("coolant." + coolant.id + ".inlet_T_C");
  }
  for (const SourceSpec& source : machine.sources)
    if (!source.drive.empty()) names.push_back(source.drive + ".power_W");
  return names;
}

/// Axes on the way from the body down to the ground.
std::set<std::string> axes_below(const Machine& machine, int body) {
  std::set<std::string> axes;
  for (; body >= 0; body = machine.body_index(machine.bodies[body].parent))
    if (const std::string& axis = machine.bodies[body].axis; !axis.empty()) axes.insert(axis);
  return axes;
}

/// Axes that move one body against the other.
std::vector<std::string> axes_between(const Machine& machine, const std::string& one, const std::string& other) {
  const auto a = axes_below(machine, machine.body_index(one)), b = axes_below(machine, machine.body_index(other));
  std::vector<std::string> between;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(between));
  return between;
}

void check_tree(const Draft& draft) {
  const Machine& machine = draft.machine;
  for (const BodySpec& body : machine.bodies) {
    std::vector<std::string> chain = {body.id};
    for (const BodySpec* at = &body; !at->parent.empty();) {
      at = &machine.bodies[machine.body_index(at->parent)];
      chain.push_back(at->id);
      if (at->id == body.id) {
        throw InputError(draft.place("body", body.id), "circular chain of parents: " + core::join(chain, " > "),
                         "parents that end at a body without parent");
      }
      if (chain.size() > machine.bodies.size()) break;  // a circle further down: reported there
    }
    if (chain.size() > machine.bodies.size()) continue;
    std::set<std::string> seen;
    for (int at = machine.body_index(body.id); at >= 0; at = machine.body_index(machine.bodies[at].parent)) {
      const std::string& axis = machine.bodies[at].axis;
      if (!axis.empty() && !seen.insert(axis).second) {
        throw InputError(draft.place("body", body.id), "axis '" + axis + "' twice between the body and the ground",
                         "each axis at most once in a chain: " + core::join(chain, " > "));
      }
    }
  }
  for (const Axis& axis : machine.axes) {
    if (std::none_of(machine.bodies.begin(), machine.bodies.end(),
                     [&](const BodySpec& b) { return b.axis == axis.id; }))
      core::warn(draft.place("axis", axis.id) + ": axis '" + axis.id + "' moves no body");
  }
}

void check_motion(const Draft& draft, const std::string& place, const std::string& axis, const std::string& one,
                  const std::string& other) {
  const std::vector<std::string> between = axes_between(draft.machine, one, other);
  const std::vector<std::string> expected = axis.empty() ? std::vector<std::string>{} : std::vector<std::string>{axis};
  if (between != expected) {
    throw InputError(
        place, axis.empty() ? std::string("no axis") : "axis '" + axis + "'",
        fmt::format("what moves '{}' against '{}' by the chain of parents: {}", one, other,
                    between.empty() ? "no axis" : core::join(between)) +
            (between.size() > 1 ? " (more than one axis between two surfaces in contact is not possible)" : ""));
  }
}

void check_joints(const Draft& draft) {
  const Machine& machine = draft.machine;
  const auto body_of = [&](const std::string& surface) -> const BodySpec& {
    const auto& id = machine.surfaces[machine.surface_index(surface)].body;
    return machine.bodies[machine.body_index(id)];
  };
  for (const JointSpec& joint : machine.joints) {
    const std::string& place = draft.place("joint", joint.id);
    std::vector<const BodySpec*> sides = {&body_of(joint.slave)};
    if (!joint.master.empty()) {
      sides.push_back(&body_of(joint.master));
      if (sides[0] == sides[1])
        throw InputError(place, "slave and master on the same body '" + sides[0]->id + "'", "surfaces of two bodies");
      check_motion(draft, place + " axis", joint.axis, sides[0]->id, sides[1]->id);
    }
    if (joint.stiffness_normal.value > 0.0 || joint.stiffness_tangential.value > 0.0) {
      for (const BodySpec* body : sides) {
        if (!body->elastic) {
          throw InputError(place, "a stiffness on body '" + body->id + "', which has elastic = false",
                           "no stiffness, or elastic = true");
        }
      }
    }
  }
  for (std::size_t i = 0; i < machine.scales.size(); ++i) {
    const ScaleSpec& scale = machine.scales[i];
    const std::string& place = draft.places.at("scale " + std::to_string(i));
    if (machine.axes[machine.axis_index(scale.axis)].kind != AxisKind::linear)
      throw InputError(place, "rotary axis '" + scale.axis + "'", "a linear axis");
    check_motion(draft, place + " axis", scale.axis, scale.head_body, scale.carrier);
    for (std::size_t j = 0; j < i; ++j) {
      if (machine.scales[j].axis == scale.axis)
        throw InputError(place, "a second scale of axis '" + scale.axis + "'", "one scale an axis");
    }
  }
}

void check_screws(const Draft& draft) {
  const Machine& machine = draft.machine;
  for (std::size_t i = 0; i < machine.screws.size(); ++i) {
    const ScrewSpec& screw = machine.screws[i];
    const std::string& place = draft.places.at("screw " + std::to_string(i));
    const BodySpec& body = machine.bodies[machine.body_index(screw.body)];
    const Axis& axis = machine.axes[machine.axis_index(screw.axis)];
    if (axis.kind != AxisKind::linear)
      throw InputError(place + " axis", "rotary axis '" + screw.axis + "'", "a linear axis");
    if (body.elastic) {
      throw InputError(place + " body", "body '" + body.id + "' with elastic = true",
                       "elastic = false: the screw's expansion enters by itself");
    }
    if (body.parent.empty() || !body.axis.empty()) {
      throw InputError(place + " body", "body '" + body.id + "' without a parent, or with an axis of its own",
                       "a screw that is fixed to the parent that carries its bearings");
    }
    for (const std::string& side : {screw.carrier, screw.nut_body}) {
      if (!machine.bodies[machine.body_index(side)].elastic) {
        throw InputError(place, "body '" + side + "' with elastic = false",
                         "elastic bodies at the bearings and at the nut");
      }
    }
    check_motion(draft, place + " axis", screw.axis, screw.nut_body, screw.carrier);
  }
}

void check_surfaces(const Draft& draft) {
  const Machine& machine = draft.machine;
  for (const SurfaceSpec& surface : machine.surfaces) {
    for (const std::string& id : surface.except) {
      if (machine.surfaces[machine.surface_index(id)].body != surface.body) {
        throw InputError(surface.place + " except", "surface '" + id + "' of another body",
                         "surfaces of body '" + surface.body + "'");
      }
    }
    // Walk the exceptions of the exceptions: one that comes back has no meaning.
    std::set<std::string> seen;
    std::vector<std::string> open = surface.except;
    while (!open.empty()) {
      const std::string id = open.back();
      open.pop_back();
      if (id == surface.id) {
        throw InputError(surface.place + " except",
                         "surface '" + surface.id + "' excludes itself through its exceptions",
                         "exceptions without a circle");
      }
      if (!seen.insert(id).second) continue;
      const auto& next = machine.surfaces[machine.surface_index(id)].except;
      open.insert(open.end(), next.begin(), next.end());
    }
  }
  const auto on_body = [&](const std::string& key, const std::string& surface, const std::string& body) {
    const std::string& found = machine.surfaces[machine.surface_index(surface)].body;
    if (found != body) {
      throw InputError(draft.places.at("tcp " + key), "surface '" + surface + "' of body '" + found + "'",
                       "a surface of body '" + body + "'");
    }
  };
  if (!machine.has_tcp()) return;
  on_body("tool_surface", machine.tcp.tool_surface, machine.tcp.tool_body);
  on_body("table_surface", machine.tcp.table_surface, machine.tcp.table_body);
}

/// A volume's films have no input of their own.
void check_loads(const Draft& draft) {
  for (const FilmSpec& film : draft.machine.films) {
    if (film.radiation_load != 0.0 && draft.machine.volume_index(film.ambient) >= 0) {
      throw InputError(draft.place("film", film.id), fmt::format("radiation_load_W_m2 = {}", film.radiation_load),
                       "0 on a film whose ambient is a volume");
    }
  }
}

}  // namespace

void check_references(const Draft& draft) {
  std::map<std::string, std::vector<std::string>> known = draft.ids;
  known["channel"] = channels(draft.machine);
  for (const std::string& channel : known["channel"])
    if (channel.ends_with(".on") || channel.ends_with(".open")) known["state channel"].push_back(channel);
  for (const char* kind : {"ambient", "volume"}) {
    for (const std::string& id : draft.ids.contains(kind) ? draft.ids.at(kind) : std::vector<std::string>{})
      known["ambient or volume"].push_back(id);
  }
  for (const Axis& axis : draft.machine.axes)
    if (axis.kind == AxisKind::rotary) known["rotary axis"].push_back(axis.id);
  known["rotary axis"].push_back("spindle");
  for (const Draft::Reference& reference : draft.references) {
    const std::vector<std::string>& ids = known[reference.kind];
    if (std::find(ids.begin(), ids.end(), reference.id) != ids.end()) continue;
    // Any drive's power may be an input: the drive need not have a source of its own.
    if (reference.kind == "channel" && reference.id.size() > 8 && reference.id.ends_with(".power_W")) continue;
    if (ids.empty()) {
      throw InputError(reference.place, "unknown " + reference.kind + " '" + reference.id + "'",
                       "an id of the file, which has no " + reference.kind + " yet");
    }
    throw InputError(reference.place, "unknown " + reference.kind + " '" + reference.id + "'",
                     "one of: " + core::join(ids) + " (nearest: " + core::nearest(reference.id, ids) + ")");
  }
}

void check_volumes(const Draft& draft) {
  // Both have the channel "<id>.T_C".
  for (const VolumeSpec& volume : draft.machine.volumes) {
    if (draft.machine.ambient_index(volume.id) >= 0) {
      throw InputError(draft.place("volume", volume.id) + " id", "'" + volume.id + "', the id of an ambient",
                       "an id of its own: both have a channel T_C");
    }
  }
}

/// A density in g/cm3.
void check_materials(const Draft& draft) {
  constexpr double lightest = 30.0;  // kg/m^3; foams are the lightest solids
  for (const Material& material : draft.machine.materials) {
    if (material.density < lightest) {
      core::warn(fmt::format("{} density_kg_m3: {} is lighter than any foam; {} g/cm3 are {} kg/m3",
                             draft.place("material", material.id), material.density, material.density,
                             1e3 * material.density));
    }
  }
}

/// A film in still air on the surface of a rotating disc, whose law holds the still air already.
void check_discs(const Draft& draft) {
  for (const FilmSpec& disc : draft.machine.films) {
    if (disc.kind != FilmKind::rotating_disc || !disc.state.empty()) continue;
    for (const FilmSpec& other : draft.machine.films) {
      const bool still = other.kind == FilmKind::constant || other.kind == FilmKind::free_convection;
      if (!still || !other.state.empty()) continue;
      for (const std::string& surface : other.surfaces) {
        if (std::find(disc.surfaces.begin(), disc.surfaces.end(), surface) == disc.surfaces.end()) continue;
        core::warn(
            fmt::format("{} surfaces: '{}' has the film '{}' as well; the law rotating_disc contains still air, "
                        "so its heat counts twice",
                        draft.place("film", other.id), surface, disc.id));
      }
    }
  }
}

void check_machine(const Draft& draft) {
  check_materials(draft);
  check_loads(draft);
  check_volumes(draft);
  check_discs(draft);
  check_tree(draft);
  check_surfaces(draft);
  check_joints(draft);
  check_screws(draft);
}

}  // namespace thermotwin::mesh::reader
