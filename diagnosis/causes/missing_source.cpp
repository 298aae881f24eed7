// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/missing_source.h"

#include <fmt/format.h>

#include <cmath>

#include "core/text.h"
#include "diagnosis/causes/kinds.h"
#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

std::string source_id(const MissingSource& source) { return "missing." + source.surface.id + "." + source.follows; }

mesh::PowerLaw law_of(const MissingSource& source, double power_W) {
  if (source.daily) return law_of(*source.daily, power_W);
  return {source.follows, {0.0, source.most}, {0.0, power_W * source.most / source.at}};
}

std::string listed(const std::vector<double>& numbers) {
  std::vector<std::string> words;
  for (const double number : numbers) words.push_back(fmt::format("{:.9g}", number));
  return core::join(words);
}

}  // namespace

double relative_power(const MissingSource& source, double value) {
  if (!std::isfinite(value)) return 0.0;
  return source.daily ? height(*source.daily, value) : std::abs(value) / source.at;
}

std::string follows_in_words(const MissingSource& source) {
  return source.daily ? "the time of day, " + in_words(*source.daily) : source.follows;
}

double magnitude(const Observations& observations, int channel, Index step) {
  const double value = observations.rows(step, channel);
  return std::isfinite(value) ? std::abs(value) : 0.0;
}

mesh::Machine with_missing_source(const mesh::Machine& machine, const Parameter& parameter, double power_W) {
  const MissingSource& missing = *parameter.missing;
  mesh::Machine changed = machine;
  if (changed.surface_index(missing.surface.id) < 0) changed.surfaces.push_back(missing.surface);
  mesh::SourceSpec source;
  source.id = source_id(missing);
  source.laws.push_back(law_of(missing, power_W));
  source.places.emplace_back();
  source.places.back().surface = missing.surface.id;
  changed.sources.push_back(std::move(source));
  return changed;
}

std::string missing_source_text(const mesh::Machine& machine, const Parameter& parameter, double power_W, double std_W,
                                const std::string& why) {
  const MissingSource& missing = *parameter.missing;
  const auto corner = [](const Vector3d& m) {
    return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", 1e3 * m.x(), 1e3 * m.y(), 1e3 * m.z());
  };
  std::string text = machine.text + (machine.text.ends_with('\n') ? "" : "\n");
  if (machine.surface_index(missing.surface.id) < 0) {
    const mesh::Rule& rule = missing.surface.any_of.front();
    text += fmt::format("\n[[surface]]\nid = \"{}\"\nbody = \"{}\"\nrule = {{ box_min_mm = {}, box_max_mm = {} }}\n",
                        missing.surface.id, missing.surface.body, corner(*rule.box_min), corner(*rule.box_max));
  }
  std::string id = source_id(missing);
  const std::string alike = missing.alike.empty() ? "" : " (or " + core::join(missing.alike, " or ") + ")";
  text += fmt::format(
      "\n[[source]]\n# diagnosis: source_missing power {} +- {} W {}{}, within {:.0f} mm "
      "of {}{}{}\nid = \"{}\"\n",
      core::plain_number(power_W, 4), core::plain_number(std_W, 2),
      missing.daily ? in_words(*missing.daily) : fmt::format("where {} = {:.6g}", missing.follows, missing.at), alike,
      1e3 * missing.region95, parameter.where, why.empty() ? "" : "; ", why, id);
  if (power_W > 0.0 && std_W > 0.0)
    text += fmt::format("scale = {{ value = 1.0, std_percent = {:.3g} }}\n", std::min(100.0, 100.0 * std_W / power_W));
  const mesh::PowerLaw law = law_of(missing, power_W);
  return text + fmt::format(
                    "law = [ {{ input = \"{}\", at = [{}], power_W = [{}] }} ]\nplace = [ {{ surface = "
                    "\"{}\" }} ]\n",
                    law.input, listed(law.at), listed(law.power), missing.surface.id);
}

core::Table source_series(const MissingSource& source, double power_W, double std_W, const Observations& obs,
                          const mesh::Machine& machine) {
  core::Table table;
  table.columns = {"time_s", "power_W", "std_W"};
  if (!obs.records.empty()) table.columns.emplace_back("record");
  table.values.resize(obs.rows.rows(), std::ssize(table.columns));
  const int channel = solver::Channels(machine).index(source.follows);
  for (std::size_t k = 0; k < obs.each().size(); ++k) {
    const Observations& record = obs.each()[k];
    for (Index s = 0; s < record.rows.rows(); ++s) {
      const double size = channel < 0 ? 1.0 : relative_power(source, record.rows(s, channel));
      auto row = table.values.row(record.offset.step + s);
      row.head<3>() << record.points[s + 1], size * power_W, size * std_W;
      if (row.size() > 3) row[3] = k + 1;
    }
  }
  return table;
}

}  // namespace thermotwin::diagnosis
