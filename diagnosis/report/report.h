// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The diagnosis as one self-contained HTML page: no other file, no network.

#include <string>
#include <vector>

#include "core/html_page.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/report/scene.h"

namespace thermotwin::diagnosis {

/// @param machine  the diagnosed machine; its text supplies the lines that the extension changes. nullptr: a record
///   without a machine
/// @param scene    3-D view of the machine with the places of the causes; may be empty
/// @param steps    commands that may follow
std::string report_html(const Diagnosis& diagnosis, const mesh::Machine* machine, const Scene& scene,
                        const std::vector<core::NextStep>& steps = {});

}  // namespace thermotwin::diagnosis
