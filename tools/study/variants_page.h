// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The page of `study variants`: the spread of the TCP error over time, the parameters that matter, next steps.

#include <string>

#include "study/plan/design.h"
#include "study/plan/plan.h"
#include "study/variants/variant_results.h"
#include "tools/study/study.h"

namespace thermotwin::tools {

struct VariantsPage {
  const StudyVariantsOptions& options;
  const study::StudyPlan& plan;
  const study::Design& design;
  const study::VariantStudy& results;
  std::string model;  ///< what computed the variants, in words
};

std::string variants_page(const VariantsPage& page);

/// "0.62 (0.58 to 0.66)"
std::string share_words(const study::Share& share);

}  // namespace thermotwin::tools
