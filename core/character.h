// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// ASCII characters. Functions of <cctype> depend on the locale and are undefined for bytes of UTF-8 in a signed char.

namespace thermotwin::core {

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
constexpr bool is_letter_or_digit(char c) { return is_letter(c) || is_digit(c); }

/// A letter in the other case; other bytes are unchanged.
constexpr char upper(char c) { return c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c; }
constexpr char lower(char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; }

/// Value of a byte, 0 to 255.
constexpr unsigned char byte_of(char c) { return static_cast<unsigned char>(c); }

}  // namespace thermotwin::core
