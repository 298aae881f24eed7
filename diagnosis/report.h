// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The diagnosis as one page of HTML that needs nothing else: no network, no script.

#include <string>

#include "diagnosis/diagnose.h"

namespace thermotwin::diagnosis {

/// @param machine  the machine that was diagnosed (its name and text, for the lines that change)
std::string report_html(const Diagnosis& diagnosis, const mesh::Machine& machine);

}  // namespace thermotwin::diagnosis
