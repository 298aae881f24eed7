// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The sections of a diagnosis's page about residuals: of each channel in numbers and over time, of each record, at a
// glance, and beside the inputs. A section without content is empty.

#include <string>

#include "diagnosis/judge/diagnosis.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// @param machine  nullptr: a record without a machine; here and below
std::string channel_table(const Diagnosis& d, const mesh::Machine* machine);
std::string records_table(const Diagnosis& d);
std::string plots(const Diagnosis& d, const mesh::Machine* machine);
std::string overview(const Diagnosis& d, const mesh::Machine* machine);
std::string analysis(const Diagnosis& d);

}  // namespace thermotwin::diagnosis
