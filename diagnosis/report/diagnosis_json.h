// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Text of diagnosis.json, whose keys diagnosis/README.md states.

#include <cstddef>
#include <string>

#include "diagnosis/judge/diagnosis.h"

namespace thermotwin::diagnosis {

/// @return name of the file with the heat over time of a named cause: source_<number>.csv  @param number  from 1
std::string series_file(std::size_t number);

/// @return the text of the file
std::string diagnosis_json(const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
