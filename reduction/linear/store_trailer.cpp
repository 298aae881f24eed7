// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/linear/store_trailer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <vector>

namespace thermotwin::reduction {
namespace {

constexpr std::string_view trailer_words = "\nthermotwin fnv8x-64 ", earlier_words = "\nthermotwin fnv1a-64 ";
constexpr std::size_t hash_digits = 16;
static_assert(store_trailer_size == trailer_words.size() + hash_digits + 1);
static_assert(trailer_words.size() == earlier_words.size());

constexpr std::uint64_t first = 0xCBF29CE484222325ULL, prime = 0x100000001B3ULL;

/// The last word is filled with zeros: pieces before the last one have a multiple of eight bytes. 100 MB take 30 ms.
std::uint64_t of_words(std::string_view bytes, std::uint64_t hash) {
  for (std::size_t at = 0; at < bytes.size(); at += sizeof hash) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min(sizeof word, bytes.size() - at));
    hash = (hash ^ word) * prime;
    hash ^= hash >> 29U;
  }
  return hash;
}

std::uint64_t of_bytes(std::string_view bytes, std::uint64_t hash) {
  for (const char byte : bytes) hash = (hash ^ (byte & 0xFF)) * prime;
  return hash;
}

bool is_earlier(std::string_view line) { return line.starts_with(earlier_words); }

std::uint64_t continued(std::string_view line, std::string_view bytes, std::uint64_t hash) {
  return is_earlier(line) ? of_bytes(bytes, hash) : of_words(bytes, hash);
}

std::string line_of(std::string_view words, std::uint64_t hash) { return fmt::format("{}{:016x}\n", words, hash); }

}  // namespace

std::string store_trailer(std::string_view bytes) { return line_of(trailer_words, of_words(bytes, first)); }

bool is_store_trailer(std::string_view line) {
  return line.size() == store_trailer_size && (is_earlier(line) || line.starts_with(trailer_words));
}

bool store_trailer_holds(std::string_view bytes, std::string_view line) {
  return line == line_of(is_earlier(line) ? earlier_words : trailer_words, continued(line, bytes, first));
}

std::string read_store_trailer(const std::filesystem::path& file) {
  constexpr std::streamoff size = store_trailer_size;
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in || in.tellg() < size) return "";
  in.seekg(-size, std::ios::end);
  std::string line(store_trailer_size, '\0');
  return in.read(line.data(), size) && is_store_trailer(line) ? line : "";
}

bool store_file_holds(const std::filesystem::path& file) {
  const std::string line = read_store_trailer(file);
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (line.empty() || !in) return false;
  const std::streamoff whole = in.tellg();
  std::uint64_t left = whole - store_trailer_size;
  in.seekg(0);
  std::vector<char> piece(1U << 18U);
  std::uint64_t hash = first;
  while (left > 0) {
    const std::size_t size = std::min<std::uint64_t>(left, piece.size());
    if (!in.read(piece.data(), size)) return false;
    hash = continued(line, {piece.data(), size}, hash);
    left -= size;
  }
  return line == line_of(is_earlier(line) ? earlier_words : trailer_words, hash);
}

}  // namespace thermotwin::reduction
