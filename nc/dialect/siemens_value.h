// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Values of a Siemens program: numbers, R parameters, + - * / DIV MOD with their precedence, brackets and functions.

#include <map>
#include <string>

namespace thermotwin::nc {

/// How a coordinate is meant: as G90 and G91 say, or by a word of its own.
enum class SiemensSense { modal, absolute, incremental, shortest, positive, negative };

struct SiemensValue {
  double number = 0;
  SiemensSense sense = SiemensSense::modal;
};

/// Numbers of the R parameters that the program has set.
using SiemensParameters = std::map<long, double>;

/// @param text  5, R1 + 2, SIN(30), AC(5), IC(R2), DC(90), ACP(0), ACN(0)
/// @param place  file:line, for messages
/// @throws InputError for a value that is none, an R parameter that the program did not set, a number beyond 1e9
SiemensValue siemens_value(const std::string& text, const SiemensParameters& parameters, const std::string& place);

/// @return the number as LinuxCNC's interpreter reads it, with seven decimals at most
std::string number_text(double value);

}  // namespace thermotwin::nc
