// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Diagnoses of the three rods of tests/machines, and what of them a failing test shows.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "tests/machines/rods_record.h"

namespace lumped {

using diagnosis::Diagnosis;

inline const reduction::ReducedModel& coarse_model() {
  static const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  return model;
}

inline Diagnosis run(const compensation::Measurement& measurement) {
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = 3;  // 27 nodes
  return diagnosis::diagnose(coarse_model(), measurement, how);
}

inline std::string listed(const Diagnosis& d) {
  std::string text = diagnosis::name_of(d.verdict) + ": " + d.sentence + "\n";
  for (std::size_t i = 0; i < std::min<std::size_t>(6, d.ranking.size()); ++i) {
    const auto& r = d.ranking[i];
    text += "  " + diagnosis::name_of(r.parameter.kind) + " " + r.parameter.where + " p " +
            std::to_string(r.probability) + " log " + std::to_string(r.log_evidence) + " value " +
            std::to_string(r.value) + " +- " + std::to_string(r.std) + "\n";
  }
  return text;
}

/// The truth is named, or among those that share.
inline void expect_found(const Diagnosis& d, const diagnosis::Parameter& truth, double value, double tolerance) {
  SCOPED_TRACE(listed(d));
  ASSERT_TRUE(d.verdict == diagnosis::Verdict::explained || d.verdict == diagnosis::Verdict::ambiguous);
  const auto& set = d.verdict == diagnosis::Verdict::explained ? d.causes : d.ambiguous_set;
  const auto at = std::find_if(set.begin(), set.end(), [&](const diagnosis::RankedCause& c) {
    return c.parameter.kind == truth.kind && c.parameter.where == truth.where;
  });
  ASSERT_NE(at, set.end());
  if (d.verdict == diagnosis::Verdict::explained) {
    EXPECT_EQ(d.causes.size(), 1u);
    EXPECT_EQ(d.ranking.front().parameter.where, truth.where);
    EXPECT_NEAR(at->value, value, tolerance);
    // The fault comes on top of a perturbed nominal value, which no diagnosis can take apart.
    EXPECT_NEAR(at->value, value, 4 * std::hypot(at->std, value * truth.nominal_std));
  }
}

}  // namespace lumped
