// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The action of a machine engineer on a cause: where to look, and for what.

#include <string>
#include <vector>

#include "diagnosis/judge/diagnosis.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

/// One sentence, such as "Look at the left rear of column, 275 mm above the table, near sensor T8: about 35 W enter
/// there in proportion to coolant.main.on."
std::string action_of(const RankedCause& cause, const reduction::ReducedModel& model);

/// "dx@1 and dx@2 changed suddenly by -3.4 +- 0.2 um at 10.29 h of the record"
std::string in_words(const StepsSeen& seen);

/// Actions for the named causes and for causes of kind other_law in the ambiguous set. If something unknown leads, an
/// action for it comes first; steps beside causes come last. If there is none of these: the action for the most
/// probable cause of the ambiguous set. Empty: nothing to do.
std::vector<std::string> actions_of(const Diagnosis& diagnosis, const reduction::ReducedModel& model);

/// Where to look besides, if nothing explains a record and one of the listed causes comes nearest. Empty: nowhere.
std::string nearest_action(const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
