// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Bytes as text (RFC 4648), for numbers that a page of HTML carries; scripts read them back as typed arrays.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace thermotwin::core {

std::string base64(const std::vector<std::uint8_t>& bytes);

/// Appends an unsigned number, lowest byte first.
template <class T>
void put_bytes(std::vector<std::uint8_t>& bytes, T value) {
  for (std::size_t k = 0; k < sizeof(T); ++k) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

}  // namespace thermotwin::core
