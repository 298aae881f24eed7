// SPDX-License-Identifier: GPL-3.0-or-later
// Ambients, films and heat sources from machine.toml.

#include "mesh/machine/physics_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mesh/machine/coolant_file.h"
#include "mesh/machine/loss_file.h"
#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

using core::InputError;
using core::Node;

namespace {

AmbientSpec read_ambient(const Node& node, Draft& draft) {
  AmbientSpec ambient;
  ambient.id = draft.define(node, "ambient");
  ambient.follows = draft.refer_or_empty(node, "follows", "ambient");
  if (ambient.follows.empty()) {
    ambient.default_C = node.uncertain("default_C");
  } else {
    // NaN until the chain of what it follows is known: resolve_defaults.
    ambient.default_C = node.uncertain_or("default_C", {std::nan(""), 0.0});
  }
  if (node.has("default_C")) draft.machine.require_plausible(ambient.default_C.value, node.place("default_C"));
  ambient.offset = node.number("offset_K");
  ambient.has_gradient = node.has("gradient_K_m");
  if (ambient.has_gradient) {
    ambient.gradient = node.uncertain("gradient_K_m");
    ambient.height = node.number("height_mm") * millimetre;
  } else {
    refuse(node, "height_mm", "together with gradient_K_m");
  }
  node.finish();
  return ambient;
}

/// An ambient without its own default has that of the one it follows, plus its offset.
void resolve_defaults(Draft& draft) {
  std::vector<AmbientSpec>& ambients = draft.machine.ambients;
  const auto find = [&](const std::string& id) {
    return std::find_if(ambients.begin(), ambients.end(), [&](const AmbientSpec& a) { return a.id == id; });
  };
  for (AmbientSpec& ambient : ambients) {
    double offset = 0.0;  // of what it follows by itself
    auto at = find(ambient.id);
    std::size_t steps = 0;
    while (at != ambients.end() && !at->follows.empty()) {
      if (++steps > ambients.size()) {
        throw InputError(draft.place("ambient", ambient.id),
                         "ambient '" + ambient.id + "' follows itself through other ambients",
                         "a chain of follows that ends at an ambient with default_C");
      }
      offset += at->offset;
      at = find(at->follows);
    }
    // An unknown id at the end of the chain is reported by check_references.
    if (std::isnan(ambient.default_C.value) && at != ambients.end())
      ambient.default_C = {at->default_C.value + offset, at->default_C.std_percent};
    if (at != ambients.end() && at->follows.empty() && (offset != 0.0 || at->offset != 0.0)) {
      draft.machine.require_plausible(at->default_C.value + at->offset + offset,
                                      draft.place("ambient", ambient.id) + " default_C with offset_K");
    }
  }
}

std::vector<std::string> refer_all(const Node& node, const std::string& key, const std::string& kind, Draft& draft) {
  std::vector<std::string> ids = node.texts(key);
  if (ids.empty()) throw InputError(node.place(key), "an empty list", "the id of one or more " + kind + "s");
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (std::find(ids.begin(), ids.begin() + i, ids[i]) != ids.begin() + i)
      throw InputError(node.place(key), "'" + ids[i] + "' twice", "each " + kind + " once");
    draft.references.push_back({kind, ids[i], node.place(key)});
  }
  return ids;
}

/// A table over a channel: of powers, or of what the key says.
PowerLaw read_law(const Node& node, Draft& draft, const std::string& key = "power_W") {
  PowerLaw law;
  law.input = draft.refer(node, "input", "channel");
  law.at = node.numbers("at");
  law.power = node.numbers(key);
  if (law.at.empty() || law.at.size() != law.power.size()) {
    throw InputError(node.place(key), fmt::format("{} numbers for {} inputs", law.power.size(), law.at.size()),
                     "as many numbers in " + key + " as in at, one or more");
  }
  for (std::size_t i = 0; i < law.at.size(); ++i) {
    // Temperatures may be negative, everything else enters by its absolute value.
    if (law.at[i] < 0.0 && table_input(law.input) != TableInput::value) {
      throw InputError(node.place("at"), fmt::format("{}", law.at[i]),
                       "numbers >= 0: the absolute value of the input is used");
    }
    if (law.at[i] > 24.0 && table_input(law.input) == TableInput::hour)
      throw InputError(node.place("at"), fmt::format("{}", law.at[i]), "hours of a day, 0 to 24");
    if (i > 0 && !(law.at[i] > law.at[i - 1]))
      throw InputError(node.place("at"), fmt::format("{} after {}", law.at[i], law.at[i - 1]), "rising numbers");
  }
  return law;
}

FilmSpec read_film(const Node& node, Draft& draft) {
  FilmSpec film;
  film.id = draft.define(node, "film");
  film.surfaces = refer_all(node, "surfaces", "surface", draft);
  film.ambient = node.text("ambient");
  draft.references.push_back({"ambient or volume", film.ambient, node.place(node.has("ambient") ? "ambient" : "id")});
  const std::string kind = node.choice("kind");
  const std::string of_constant = "film_coefficient_W_m2K belongs to kind = \"constant\"; a law has factor";
  if (kind == "table") {
    film.kind = FilmKind::table;
    film.coefficient = node.uncertain("factor");
    film.table = read_law(node, draft, "film_coefficient_W_m2K");
  } else if (kind == "constant") {
    film.kind = FilmKind::constant;
    film.coefficient = node.uncertain("film_coefficient_W_m2K");
    refuse(node, "factor", "factor belongs to a law; kind = \"constant\" has film_coefficient_W_m2K");
  } else {
    refuse(node, "film_coefficient_W_m2K", of_constant);
    film.coefficient = node.uncertain("factor");
  }
  if (kind == "free_convection") {
    film.kind = FilmKind::free_convection;
    const std::string way = node.choice("orientation");
    film.orientation = way == "up" ? Orientation::up : way == "down" ? Orientation::down : Orientation::vertical;
    film.length = node.number("length_m");
    film.of_temperature = node.boolean("of_temperature");
    if (film.of_temperature) refuse(node, "delta_K", "of_temperature = true takes the surface's own difference");
    film.delta = node.number("delta_K");
  } else {
    for (const char* key : {"orientation", "length_m", "delta_K", "of_temperature"})
      refuse(node, key, "kind = \"free_convection\"");
  }
  if (kind != "table")
    for (const char* key : {"input", "at"}) refuse(node, key, "kind = \"table\"");
  if (kind == "rotating_disc") {
    film.kind = FilmKind::rotating_disc;
    film.axis = node.text("axis");
    if (film.axis != "spindle") draft.references.push_back({"rotary axis", film.axis, node.place("axis")});
    film.radius = node.number("radius_mm") * millimetre;
    film.fraction = node.number("fraction");
  } else {
    for (const char* key : {"axis", "radius_mm", "fraction"}) refuse(node, key, "kind = \"rotating_disc\"");
  }
  film.emissivity = node.uncertain("emissivity");
  if (film.emissivity.value > 0.0) {
    film.exact_radiation = node.choice("radiation") == "exact";
    film.surroundings = draft.refer_or_empty(node, "surroundings", "ambient");
  } else {
    for (const char* key : {"radiation", "surroundings"}) refuse(node, key, "together with emissivity > 0");
  }
  const bool has_speed =
      kind == "rotating_disc" || (kind == "table" && table_input(film.table.input) == TableInput::magnitude);
  if (has_speed)
    film.speed_factor = node.number("speed_factor");
  else
    refuse(node, "speed_factor", "kind = \"rotating_disc\" or a \"table\" over a speed");
  film.radiation_load = node.number("radiation_load_W_m2");
  film.state = node.text_or("state", "");
  if (!film.state.empty()) draft.references.push_back({"state channel", film.state, node.place("state")});
  node.finish();
  return film;
}

SourcePlace read_place(const Node& node, Draft& draft) {
  SourcePlace place;
  const int given = (node.has("surface") ? 1 : 0) + (node.has("joint") ? 1 : 0) + (node.has("volume") ? 1 : 0);
  if (given != 1) {
    throw InputError(node.place(),
                     given == 0 ? "none of surface, joint, volume" : "more than one of surface, joint, volume",
                     "one of: surface, joint, volume");
  }
  place.surface = draft.refer_or_empty(node, "surface", "surface");
  place.volume = draft.refer_or_empty(node, "volume", "volume");
  place.joint = draft.refer_or_empty(node, "joint", "joint");
  place.share = node.number("share");
  if (place.joint.empty())
    refuse(node, "slave_share", "together with joint");
  else
    place.slave_share = node.number("slave_share");
  node.finish();
  return place;
}

SourceSpec read_source(const Node& node, Draft& draft) {
  SourceSpec source;
  source.id = draft.define(node, "source");
  source.drive = node.text_or("drive", "");
  if (source.drive.empty())
    refuse(node, "drive_loss_share", "together with drive");
  else
    source.drive_loss_share = node.number("drive_loss_share");
  source.scale = node.uncertain("scale");
  source.standstill = node.number("standstill_W");
  source.speed_exponent = node.number("speed_exponent");
  for (const Node& law : node.tables("law")) {
    if (law.has("kind")) {
      source.losses.push_back(read_loss(law, draft));
    } else {
      source.laws.push_back(read_law(law, draft));
      law.finish();
    }
  }
  double total = 0.0;
  for (const Node& place : node.tables("place")) {
    source.places.push_back(read_place(place, draft));
    total += source.places.back().share;
  }
  node.finish();
  if (source.laws.empty() && source.losses.empty() && source.drive.empty() && source.standstill == 0.0) {
    throw InputError(node.place(), "a source without power",
                     "law = [ {input, at, power_W} or {kind, motion, ...} ], drive or standstill_W");
  }
  if (source.places.empty())
    throw InputError(node.place(), "a source without a place", "place = [ {surface, joint or volume, share} ]");
  if (total > 1.0 + 1e-9) {
    throw InputError(node.place("place"), fmt::format("shares that add to {:.6g}", total),
                     "shares that add to at most 1 (the rest goes to the air)");
  }
  return source;
}

}  // namespace

void read_physics(const Node& root, Draft& draft) {
  Machine& machine = draft.machine;
  for (const Node& node : root.tables("ambient")) machine.ambients.push_back(read_ambient(node, draft));
  resolve_defaults(draft);
  read_volumes(root, draft);
  for (const Node& node : root.tables("film")) machine.films.push_back(read_film(node, draft));
  read_coolants(root, draft);
  for (const Node& node : root.tables("source")) machine.sources.push_back(read_source(node, draft));
}

}  // namespace thermotwin::mesh::reader
