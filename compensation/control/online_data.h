// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Online data: what `compensate` and `serve` need of a reduced model, as one flat block of bytes, so that a start needs
// neither the model file nor what takes time to derive from it. online_file.h keeps it beside the model.
//
// All that follows from machine.toml in milliseconds is derived anew at each start by the code that a start from the
// model file runs; the block has the matrices and DerivedData. So its numbers can be checked against the counts of the
// machine, the machine's own indices need no check, and both starts give the same bits.
//
// The block: a head (magic, version, size, sum of what follows), the key, then texts and arrays, each with its length
// and from a multiple of eight bytes, in the byte order of the processor. A change within any one word changes the sum.

#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>

#include "compensation/control/control_model.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

inline constexpr std::uint64_t online_version = 1;

struct OnlineData {
  /// Without terms, parts, patches, trained range, air beside the sensors and mesh error.
  reduction::ReducedModel model;
  DerivedData derived;
};

/// What a block belongs to.
struct OnlineKey {
  std::string program;     ///< build that derived the data
  std::string model_line;  ///< last line of the model file, the hash of all before it (store_trailer.h)
  std::array<std::int64_t, 4> model_stamp{};  ///< file_stamp() of the model file when its content was checked; 0: none
  std::int64_t order = 0;                     ///< that was asked for; 0: the model's own
};

/// Drops what OnlineData does not have.
void keep_online(reduction::ReducedModel& model);
/// @return whether all numbers are finite, as a block needs them
bool can_be_stored(const OnlineData& data);
std::string online_bytes(const OnlineKey& key, const OnlineData& data);
/// The sum of a head over what follows it. @param body  a multiple of eight bytes
std::uint64_t online_sum(std::string_view body);

/// A block in a file or in memory.
class OnlineReader {
public:
  /// Reads head and key. @param in  must outlive the reader  @param name  in messages
  /// @throws InputError for what is no block, or one of another version
  OnlineReader(std::istream& in, std::string name);

  const OnlineKey& key() const { return key_; }
  /// Reads the rest. @param model_file  for the machine's paths and messages
  /// @throws InputError for a damaged block
  OnlineData read(const std::filesystem::path& model_file);

private:
  class Source;
  std::istream& in_;
  std::string name_;
  std::uint64_t left_ = 0, sum_ = 0, stated_sum_ = 0;  ///< bytes to come; sum so far, and that of the head
  OnlineKey key_;
};

}  // namespace thermotwin::compensation
