// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Text helpers of pages and their scripts; xml_text() is in core/text.h.

#include <string>
#include <string_view>

namespace thermotwin::core {

/// A unit as a page writes it: "°C" for degC, "µm/h" for um/h, "W/m²" for W/m2; others as they are.
std::string unit_text(std::string_view unit);

/// @return text as a string of JSON, in quotes; safe inside a script element of a page, because < and > are escaped
std::string json_text(std::string_view text);

}  // namespace thermotwin::core
