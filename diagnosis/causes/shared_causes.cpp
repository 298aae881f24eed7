// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/shared_causes.h"

#include <algorithm>
#include <string>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/offered_causes.h"

namespace thermotwin::diagnosis {

namespace {

/// How a sensor hangs and how slow it is does not change from day to day.
bool may_differ(Kind kind) { return kind != Kind::sensor_lag && kind != Kind::sensor_detached; }

/// Once, as wide as the widest of those that are the same.
void merge(const Parameter& p, std::vector<Parameter>& all) {
  for (Parameter& known : all) {
    if (known.kind != p.kind || known.where != p.where) continue;
    known.nominal_std = std::max(known.nominal_std, p.nominal_std);
    known.cause_std = std::max(known.cause_std, p.cause_std);
    known.low = std::min(known.low, p.low);
    return;
  }
  all.push_back(p);
}

/// @param record  name of the record whose channels are called RECORD/CHANNEL
void add_reading(Parameter p, const std::string& record, std::vector<Parameter>& all) {
  const std::string prefix = record + "/";
  const bool of_device = !p.where.starts_with(prefix);
  Parameter everywhere = p;
  if (!of_device) everywhere.where.erase(0, prefix.size());
  merge(everywhere, all);
  if (!may_differ(p.kind)) return;
  if (of_device) p.where.insert(0, prefix);
  p.of_record = true;
  all.push_back(std::move(p));
}

}  // namespace

std::vector<Parameter> candidates_of_records(const mesh::Machine& machine, Records records,
                                             const Observations& observations, bool with_parts) {
  std::vector<Parameter> all;
  for (std::size_t k = 0; k < records.size(); ++k) {
    const Observations& record = observations.each()[k];
    const std::vector<Parameter> own = candidate_parameters(machine, records[k], with_parts, record.told_row_s);
    if (records.size() == 1) return own;
    for (const Parameter& p : own) {
      if (acts_on_readings(p.kind))
        add_reading(p, record.name, all);
      else
        merge(p, all);
    }
  }
  return all;
}

}  // namespace thermotwin::diagnosis
