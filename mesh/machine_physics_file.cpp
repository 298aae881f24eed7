// SPDX-License-Identifier: GPL-3.0-or-later
// Ambients, films, coolants and heat sources from machine.toml.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mesh/machine_reader.h"

namespace thermotwin::mesh::reader {

using core::InputError;
using core::Node;

namespace {

// Bounds are generous, but catch a wrong unit and what would overflow in a product.
constexpr core::Range share{0.0, 1.0};
constexpr double largest_power = 1e9;  // W

AmbientSpec read_ambient(const Node& node, Draft& draft) {
  AmbientSpec ambient;
  ambient.id = draft.define(node, "ambient");
  ambient.follows = draft.refer_or_empty(node, "follows", "ambient");
  if (ambient.follows.empty()) {
    ambient.default_C = node.uncertain("default_C", {-100.0, 500.0});
  } else {
    // NaN until the chain of what it follows is known: resolve_defaults.
    ambient.default_C = node.uncertain_or("default_C", {std::nan(""), 0.0}, {-100.0, 500.0});
  }
  ambient.offset = node.number_or("offset_K", 0.0, {-200.0, 200.0});
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
    double offset = 0.0;
    auto at = find(ambient.id);
    std::size_t steps = 0;
    while (at != ambients.end() && !at->follows.empty()) {
      if (++steps > ambients.size())
        throw InputError(draft.place("ambient", ambient.id),
                         "ambient '" + ambient.id + "' follows itself in the end",
                         "a chain of follows that ends at an ambient with default_C");
      offset += at->offset;
      at = find(at->follows);
    }
    // An unknown id at the end of the chain is reported by check_references.
    if (std::isnan(ambient.default_C.value) && at != ambients.end())
      ambient.default_C = {at->default_C.value + offset, at->default_C.std_percent};
  }
}

std::vector<std::string> refer_all(const Node& node, const std::string& key, const std::string& kind,
                                   Draft& draft) {
  std::vector<std::string> ids = node.texts(key);
  if (ids.empty()) throw InputError(node.place(key), "an empty list", "the id of one or more " + kind + "s");
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (std::find(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(i), ids[i]) !=
        ids.begin() + static_cast<std::ptrdiff_t>(i))
      throw InputError(node.place(key), "'" + ids[i] + "' twice", "each " + kind + " once");
    draft.references.push_back({kind, ids[i], node.place(key)});
  }
  return ids;
}

FilmSpec read_film(const Node& node, Draft& draft) {
  FilmSpec film;
  film.id = draft.define(node, "film");
  film.surfaces = refer_all(node, "surfaces", "surface", draft);
  film.ambient = node.text_or("ambient", "air");
  draft.references.push_back({"ambient", film.ambient, node.place(node.has("ambient") ? "ambient" : "id")});
  const std::string kind =
      node.choice_or("kind", "constant", {"constant", "free_convection", "rotating_disc"});
  const std::string of_constant = "film_coefficient_W_m2K belongs to kind = \"constant\"; a law has factor";
  if (kind == "constant") {
    film.kind = FilmKind::constant;
    film.coefficient = node.uncertain("film_coefficient_W_m2K", {0.0, 1e6});
    refuse(node, "factor", "factor belongs to a law; kind = \"constant\" has film_coefficient_W_m2K");
  } else {
    refuse(node, "film_coefficient_W_m2K", of_constant);
    film.coefficient = node.uncertain_or("factor", {1.0, 0.0}, {0.0, 1e3});
  }
  if (kind == "free_convection") {
    film.kind = FilmKind::free_convection;
    const std::string way = node.choice_or("orientation", "vertical", {"vertical", "up", "down"});
    film.orientation = way == "up"     ? Orientation::up
                       : way == "down" ? Orientation::down
                                       : Orientation::vertical;
    film.length = node.number_or("length_m", film.length, {1e-3, 100.0});
    film.delta = node.number_or("delta_K", film.delta, {1e-3, 500.0});
  } else {
    for (const char* key : {"orientation", "length_m", "delta_K"})
      refuse(node, key, "kind = \"free_convection\"");
  }
  if (kind == "rotating_disc") {
    film.kind = FilmKind::rotating_disc;
    film.axis = node.text("axis");
    if (film.axis != "spindle") draft.references.push_back({"rotary axis", film.axis, node.place("axis")});
    film.radius = node.number("radius_mm", {0.01, 1e5}) * millimetre;
    film.fraction = node.number_or("fraction", 1.0, share);
  } else {
    for (const char* key : {"axis", "radius_mm", "fraction"}) refuse(node, key, "kind = \"rotating_disc\"");
  }
  film.emissivity = node.number_or("emissivity", 0.0, share);
  film.state = node.text_or("state", "");
  if (!film.state.empty()) draft.references.push_back({"state channel", film.state, node.place("state")});
  node.finish();
  return film;
}

CoolantSpec read_coolant(const Node& node, Draft& draft) {
  CoolantSpec coolant;
  coolant.id = draft.define(node, "coolant");
  coolant.flow = node.uncertain("flow_kg_s", {1e-9, 1e4});
  coolant.specific_heat = node.number_or("specific_heat_J_kgK", coolant.specific_heat, {10.0, 20000.0});
  coolant.density = node.number_or("density_kg_m3", coolant.density, {0.01, 30000.0});
  coolant.guide_sensor = draft.refer_or_empty(node, "guide_sensor", "sensor");
  if (coolant.guide_sensor.empty()) draft.references.push_back({"ambient", "air", node.place()});
  coolant.guide_offset = node.number_or("guide_offset_K", 0.0, {-100.0, 100.0});
  coolant.time_constant = node.number_or("time_constant_s", coolant.time_constant, {1e-3, 1e9});
  coolant.two_point = node.choice_or("control", "lag", {"lag", "two_point"}) == "two_point";
  if (coolant.two_point) {
    coolant.band = node.number_or("band_K", coolant.band, core::positive);
    // An outlet that heads for a place inside the band would never switch.
    const core::Range beyond{0.5001 * coolant.band, 1e3};
    coolant.pull_down = node.number_or("pull_down_K", std::max(coolant.pull_down, coolant.band), beyond);
    coolant.drift_up = node.number_or("drift_up_K", std::max(coolant.drift_up, coolant.band), beyond);
  } else {
    for (const char* key : {"band_K", "pull_down_K", "drift_up_K"}) refuse(node, key, "control = \"two_point\"");
  }
  std::vector<std::string> seen;
  for (const Node& part : node.tables("segment")) {
    CoolantSegment segment;
    segment.id = part.text("id");
    core::require_unique_id(segment.id, part.place("id"), seen);
    segment.surface = draft.refer(part, "surface", "surface");
    segment.film_coefficient = part.uncertain("film_coefficient_W_m2K", {0.0, 1e6});
    segment.volume = part.number_or("volume_l", 0.5, {1e-6, 1e6}) * 1e-3;
    part.finish();
    coolant.segments.push_back(std::move(segment));
  }
  if (coolant.segments.empty())
    throw InputError(node.place(), "a coolant without [[coolant.segment]]",
                     "one or more segments, in order of flow");
  node.finish();
  return coolant;
}

PowerLaw read_law(const Node& node, Draft& draft) {
  PowerLaw law;
  law.input = draft.refer(node, "input", "channel");
  law.at = node.numbers("at");
  law.power = node.numbers("power_W");
  node.finish();
  if (law.at.empty() || law.at.size() != law.power.size())
    throw InputError(node.place("power_W"),
                     fmt::format("{} powers for {} inputs", law.power.size(), law.at.size()),
                     "as many numbers in power_W as in at, one or more");
  for (std::size_t i = 0; i < law.at.size(); ++i) {
    // Temperatures may be negative, everything else enters by its absolute value.
    if (law.at[i] < 0.0 && !law.input.ends_with(".T_C"))
      throw InputError(node.place("at"), fmt::format("{}", law.at[i]),
                       "numbers >= 0: the absolute value of the input is used");
    if (std::abs(law.power[i]) > largest_power)
      throw InputError(node.place("power_W"), fmt::format("{}", law.power[i]),
                       fmt::format("at most {:.0e} W", largest_power));
    if (i > 0 && !(law.at[i] > law.at[i - 1]))
      throw InputError(node.place("at"), fmt::format("{} after {}", law.at[i], law.at[i - 1]),
                       "rising numbers");
  }
  return law;
}

SourcePlace read_place(const Node& node, Draft& draft) {
  SourcePlace place;
  if (node.has("surface") == node.has("joint"))
    throw InputError(node.place(), node.has("surface") ? "surface and joint" : "neither surface nor joint",
                     "one of: surface, joint");
  place.surface = draft.refer_or_empty(node, "surface", "surface");
  place.joint = draft.refer_or_empty(node, "joint", "joint");
  place.share = node.number_or("share", 1.0, share);
  if (place.joint.empty())
    refuse(node, "slave_share", "together with joint");
  else
    place.slave_share = node.number_or("slave_share", 0.5, share);
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
    source.drive_loss_share = node.number_or("drive_loss_share", 1.0, share);
  source.scale = node.uncertain_or("scale", {1.0, 0.0}, {0.0, 1e6});
  for (const Node& law : node.tables("law")) source.laws.push_back(read_law(law, draft));
  double total = 0.0;
  for (const Node& place : node.tables("place")) {
    source.places.push_back(read_place(place, draft));
    total += source.places.back().share;
  }
  node.finish();
  if (source.laws.empty() && source.drive.empty())
    throw InputError(node.place(), "a source without power", "law = [ {input, at, power_W} ] or drive");
  if (source.places.empty())
    throw InputError(node.place(), "a source without a place", "place = [ {surface or joint, share} ]");
  if (total > 1.0 + 1e-9)
    throw InputError(node.place("place"), fmt::format("shares that add to {:.6g}", total),
                     "shares that add to at most 1 (the rest goes to the air)");
  return source;
}

}  // namespace

void read_physics(const Node& root, Draft& draft) {
  Machine& machine = draft.machine;
  for (const Node& node : root.tables("ambient")) machine.ambients.push_back(read_ambient(node, draft));
  resolve_defaults(draft);
  for (const Node& node : root.tables("film")) machine.films.push_back(read_film(node, draft));
  for (const Node& node : root.tables("coolant")) machine.coolants.push_back(read_coolant(node, draft));
  for (const Node& node : root.tables("source")) machine.sources.push_back(read_source(node, draft));
}

}  // namespace thermotwin::mesh::reader
