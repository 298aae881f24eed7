// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Text helpers that messages and tables share.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace thermotwin::core {

/// @return the Levenshtein distance: the number of inserted, deleted and replaced bytes that turn a into b
std::size_t edit_distance(std::string_view a, std::string_view b);

/// @return the candidate with the smallest edit distance to word; empty if there is none
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

/// Converts ASCII letters to one case; other bytes are unchanged.
std::string lower(std::string_view text);
std::string upper(std::string_view text);

/// Without blanks, tabs and line ends at both ends.
std::string_view trimmed(std::string_view text);

/// @return a quoted TOML string, escaped as TOML requires
std::string toml_text(std::string_view text);
/// @return "a, b, c"
std::string join(const std::vector<std::string>& words, std::string_view separator = ", ");

/// @return a number with so many significant digits and without an exponent: 358.2 with two is "360", 0.0123 "0.012".
///   Numbers of 1e9 and more, or below 1e-5, keep it
std::string plain_number(double value, int digits);

/// @return text for XML and HTML: & < > " are replaced, control characters but tab and line feed are left out
std::string xml_text(std::string_view text);

/// @return a fixed-width table for the terminal; the first row is the header, and numbers are aligned right
std::string format_table(const std::vector<std::vector<std::string>>& rows);

/// @return the offset of the first byte that is not well-formed UTF-8 (RFC 3629); nothing if there is none
std::optional<std::size_t> find_invalid_utf8(std::string_view text);

/// @return the offset of the first byte of a TOML document that is not ASCII and outside of quoted texts and comments;
///   nothing if there is none. A byte order mark at the start is skipped
std::optional<std::size_t> find_bare_non_ascii(std::string_view toml);

}  // namespace thermotwin::core
