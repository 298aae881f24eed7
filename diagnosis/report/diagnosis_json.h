// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// diagnosis.json.

#include <cstddef>
#include <string>

#include "diagnosis/judge/diagnosis.h"

namespace thermotwin::diagnosis {

/// File with the heat over time of a named cause, which number counts from 1.
std::string series_file(std::size_t number);

/// The JSON of DESIGN's contract.
std::string diagnosis_json(const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
