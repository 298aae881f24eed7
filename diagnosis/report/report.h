// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The diagnosis as one page of HTML that needs nothing else: no network.

#include <string>

#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/report/scene.h"

namespace thermotwin::diagnosis {

/// @param machine  the machine that was diagnosed (its name and text, for the lines that change); nullptr: a record
///   without one
/// @param scene    where causes are; may be empty
std::string report_html(const Diagnosis& diagnosis, const mesh::Machine* machine, const Scene& scene);

}  // namespace thermotwin::diagnosis
