// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/words.h"

#include <gtest/gtest.h>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {
namespace {

TEST(DiagnosisWords, LargeDeviationsArePlainNumbers) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::explained;
  RankedCause cause;
  cause.parameter = make_parameter(Kind::source_power, "motor");
  cause.parameter.name = "time_constant";
  cause.parameter.unit = "s";
  cause.value = 2170.0;
  cause.std = 358.0;
  cause.probability = 0.99;
  diagnosis.causes.push_back(cause);
  const std::string sentence = sentence_of(diagnosis);
  EXPECT_NE(sentence.find("(time_constant 2170 +- 360 s)"), std::string::npos) << sentence;
}

}  // namespace
}  // namespace thermotwin::diagnosis
