// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The verbs and options of the program as its `--help` lists them.

#include <set>
#include <string>
#include <vector>

namespace thermotwin::cases {

std::vector<std::string> verbs();

/// "--out", "-h", ... of the verb and of the verbs in its group; empty for an unknown verb
std::set<std::string> options_of(const std::string& verb);

}  // namespace thermotwin::cases
