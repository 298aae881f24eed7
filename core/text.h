// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Small text helpers shared by messages and tables.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace thermotwin::core {

/// Levenshtein distance: inserted, deleted and replaced bytes that turn a into b.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate with the smallest edit distance to word; empty if there is none.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

/// Letters of ASCII in one case; other bytes stay.
std::string lower(std::string_view text);
std::string upper(std::string_view text);

/// Without blanks, tabs and line ends at both ends.
std::string_view trimmed(std::string_view text);

/// "a, b, c"
std::string join(const std::vector<std::string>& words, std::string_view separator = ", ");

/// Text for XML and HTML: & < > " are replaced, control characters but tab and line feed left out.
std::string xml_text(std::string_view text);

/// Fixed-width text table for the terminal: first row is the header, numbers align right.
std::string format_table(const std::vector<std::vector<std::string>>& rows);

/// Offset of the first byte that is not well-formed UTF-8 (RFC 3629); nothing if all is well.
std::optional<std::size_t> find_invalid_utf8(std::string_view text);

/// Offset of the first byte of a TOML document that is not ASCII and stands neither in a quoted text
/// nor in a comment; nothing if there is none. A byte order mark at the start is passed over.
std::optional<std::size_t> find_bare_non_ascii(std::string_view toml);

}  // namespace thermotwin::core
