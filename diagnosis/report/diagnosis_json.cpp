// SPDX-License-Identifier: GPL-3.0-or-later
// diagnosis.json: the contract with programs that read a diagnosis.

#include "diagnosis/report/diagnosis_json.h"

#include <nlohmann/json.hpp>

#include "core/units.h"
#include "diagnosis/judge/diagnosis.h"

namespace thermotwin::diagnosis {

namespace {

using Json = nlohmann::ordered_json;

Json identity(const RankedCause& cause) {
  return {{"kind", name_of(cause.parameter.kind)}, {"where", cause.parameter.where}};
}

/// @param number  of the cause, from 1
Json named(const RankedCause& cause, std::size_t number) {
  Json json = identity(cause);
  json["probability"] = cause.probability;
  json["parameters"] = {
      {cause.parameter.name, {{"value", cause.value}, {"std", cause.std}, {"unit", cause.parameter.unit}}}};
  if (is_step(cause.parameter.kind)) {
    json["since_h"] = {{"value", cause.parameter.from_s / core::units::hour},
                       {"std", cause.parameter.from_std_s / core::units::hour}};
  }
  if (const auto& missing = cause.parameter.missing) {
    const Eigen::Vector3d mm = 1e3 * missing->centre;
    json["location"] = {
        {"body", missing->body}, {"centre_mm", {mm.x(), mm.y(), mm.z()}}, {"region95_mm", 1e3 * missing->region95}};
    if (const auto& place = cause.place) {
      const Eigen::Vector3d skin_mm = place->on_skin / core::units::mm;
      json["location"]["on_skin_mm"] = {skin_mm.x(), skin_mm.y(), skin_mm.z()};
      json["location"]["nearest_surface"] = place->surface.empty() ? Json(nullptr) : Json(place->surface);
      json["location"]["surface_distance_mm"] =
          place->surface.empty() ? Json(nullptr) : Json(place->surface_m / core::units::mm);
    }
    json["series"] = series_file(number);
    json["follows"] = missing->follows;
    if (const auto& daily = missing->daily) {
      const auto hour = [](double h) { return mesh::at_input(mesh::TableInput::hour, h); };
      json["hours_of_day"] = {hour(daily->from_h), hour(daily->to_h)};
    }
    if (!missing->alike.empty()) json["follows_or"] = missing->alike;
  }
  return json;
}

/// Of several ones, each in its own time.
Json records(const Diagnosis& diagnosis) {
  Json all = Json::array();
  for (const DiagnosedRecord& record : diagnosis.records) {
    all.push_back({{"name", record.name},
                   {"from_s", record.from_s},
                   {"to_s", record.to_s},
                   {"heldout_from_s", record.heldout_from_s},
                   {"heldout_rms_before_um", record.rms_before_um},
                   {"heldout_rms_after_um", record.rms_after_um}});
  }
  return all;
}

}  // namespace

std::string series_file(std::size_t number) { return "source_" + std::to_string(number) + ".csv"; }

std::string diagnosis_json(const Diagnosis& diagnosis) {
  Json json;
  json["schema"] = 1;
  json["verdict"] = name_of(diagnosis.verdict);
  json["sentence"] = diagnosis.sentence;
  json["actions"] = diagnosis.actions;
  json["reading_steps"] = Json::array();
  for (const ReadingStep& step : diagnosis.steps.steps) {
    json["reading_steps"].push_back({{"channels", diagnosis.steps.channels},
                                     {"quantity", diagnosis.steps.quantity},
                                     {"at_h", step.from_s / core::units::hour},
                                     {"size", step.size},
                                     {"std", step.std},
                                     {"time_constant_h", step.memory_s / core::units::hour},
                                     {"unit", diagnosis.steps.unit}});
  }
  json["causes"] = Json::array();
  for (std::size_t i = 0; i < diagnosis.causes.size(); ++i) json["causes"].push_back(named(diagnosis.causes[i], i + 1));
  json["ranking"] = Json::array();
  for (const RankedCause& cause : diagnosis.ranking) {
    Json row = identity(cause);
    row["probability"] = cause.probability;
    row["log_evidence"] = cause.log_evidence;
    json["ranking"].push_back(std::move(row));
  }
  json["explanations"] = Json::array();
  for (const Explanation& one : diagnosis.explanations) {
    json["explanations"].push_back({{"name", one.name},
                                    {"probability", one.probability},
                                    {"log_evidence", one.log_evidence ? Json(*one.log_evidence) : Json(nullptr)}});
  }
  json["ambiguous_set"] = Json::array();
  for (const RankedCause& cause : diagnosis.ambiguous_set) json["ambiguous_set"].push_back(identity(cause));
  if (!diagnosis.records.empty()) json["records"] = records(diagnosis);
  json["residual"]["per_channel"] = Json::array();
  for (const ChannelResidual& channel : diagnosis.residuals) {
    json["residual"]["per_channel"].push_back({{"id", channel.id},
                                               {"rms_before", channel.rms_before},
                                               {"rms_after", channel.rms_after},
                                               {"unit", channel.unit},
                                               {"p_value_white", channel.p_value_white}});
    if (!diagnosis.records.empty())
      json["residual"]["per_channel"].back()["record"] = diagnosis.records[channel.record].name;
  }
  json["residual"]["analysis"] = Json::array();
  for (const ResidualAnalysis& a : diagnosis.analysis) {
    json["residual"]["analysis"].push_back({{"id", a.id},
                                            {"rms_over_expected", a.ratio},
                                            {"mean", a.mean},
                                            {"peak", a.peak},
                                            {"peak_time_s", a.peak_time_s},
                                            {"memory_s", a.memory_s},
                                            {"follows", a.follows},
                                            {"delay_s", a.delay_s},
                                            {"correlation", a.correlation}});
  }
  json["detectability"] = Json::array();
  for (const Detectable& row : diagnosis.detectable) {
    json["detectability"].push_back({{"kind", name_of(row.kind)},
                                     {"unit", row.ratio ? "share of nominal" : row.unit},
                                     {"least", row.least},
                                     {"best_where", row.best},
                                     {"most", row.most},
                                     {"worst_where", row.worst},
                                     {"invisible", row.invisible}});
  }
  json["gain"] = {{"heldout_rms_before_um", diagnosis.heldout_rms_before_um},
                  {"heldout_rms_after_um", diagnosis.heldout_rms_after_um},
                  {"reduction_percent", diagnosis.reduction_percent},
                  {"ci95_percent", {diagnosis.ci95_low_percent, diagnosis.ci95_high_percent}}};
  json["next_measurement"] = {{"load", diagnosis.next.load},
                              {"channel", diagnosis.next.channel},
                              {"why", diagnosis.next.why},
                              {"duration_h", diagnosis.next.duration_h},
                              {"outcomes", diagnosis.next.outcomes}};
  json["extended_machine"] = diagnosis.extended_machine_text.empty() ? Json(nullptr) : Json("extended/machine.toml");
  json["warnings"] = diagnosis.warnings;
  json["notes"] = diagnosis.notes;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace thermotwin::diagnosis
