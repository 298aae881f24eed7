// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The verdict of a diagnosis and its name in diagnosis.json. Rules: docs/explanation/verdicts.md.

#include <optional>
#include <string>

namespace thermotwin::diagnosis {

enum class Verdict {
  explained,       ///< one or two causes explain the discrepancy with high probability
  no_discrepancy,  ///< the record agrees with the machine within its stated uncertainty
  ambiguous,       ///< several causes explain the record, and it cannot distinguish them
  unexplained      ///< no known kind of cause explains the discrepancy
};

inline std::string name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::explained: return "explained";
    case Verdict::no_discrepancy: return "no_discrepancy";
    case Verdict::ambiguous: return "ambiguous";
    case Verdict::unexplained: return "unexplained";
  }
  return "";
}

/// @return nothing if no verdict has this name
inline std::optional<Verdict> verdict_named(const std::string& name) {
  for (const Verdict verdict : {Verdict::explained, Verdict::no_discrepancy, Verdict::ambiguous, Verdict::unexplained})
    if (name_of(verdict) == name) return verdict;
  return std::nullopt;
}

}  // namespace thermotwin::diagnosis
