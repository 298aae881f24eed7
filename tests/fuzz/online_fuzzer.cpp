// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as online data, and a good block whose words the bytes replace, with the right checksum: data that a twin
// runs on, or an InputError.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "compensation/control/online_data.h"
#include "compensation/control/online_twin.h"
#include "core/error.h"
#include "tests/fuzz/require.h"
#include "tests/machines/rods.h"

using namespace thermotwin;

namespace {

constexpr std::size_t head_bytes = 32, size_at = 16, sum_at = 24;

const std::string& good_block() {
  static const std::string block = [] {
    compensation::OnlineData data{lumped::model(lumped::machine(), 2), {}};
    data.derived = compensation::derived_data(data.model, compensation::ControlOptions().tolerance);
    return compensation::online_bytes({"build", "line", {}, 0}, data);
  }();
  return block;
}

void replace_words(std::string& block, const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t place_bytes = 3, word = 8, record = place_bytes + word;
  for (; size >= record; data += record, size -= record) {
    const std::size_t place =
        data[0] | static_cast<std::size_t>(data[1]) << 8U | static_cast<std::size_t>(data[2]) << 16U;
    std::memcpy(block.data() + head_bytes + place % (block.size() - head_bytes - word + 1), data + place_bytes, word);
  }
}

void seal(std::string& block) {
  block.resize(std::max(block.size(), head_bytes) / 8 * 8, '\0');
  const std::uint64_t size = block.size(), sum = compensation::online_sum(std::string_view(block).substr(head_bytes));
  std::memcpy(block.data(), good_block().data(), size_at);
  std::memcpy(block.data() + size_at, &size, sizeof size);
  std::memcpy(block.data() + sum_at, &sum, sizeof sum);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const bool any = data[0] % 2 == 1;
  std::string block = any ? std::string(reinterpret_cast<const char*>(data + 1), size - 1) : good_block();
  if (!any) replace_words(block, data + 1, size - 1);
  if (!any || data[0] % 4 == 3) seal(block);
  std::istringstream in(block);
  try {
    compensation::OnlineData read = compensation::OnlineReader(in, "fuzzed.online").read("fuzzed.rom.h5");
    const std::string again = compensation::online_bytes({"build", "line", {}, 0}, read);
    require(again.size() % 8 == 0, "what was read can be written");
    compensation::OnlineTwin twin(read.model, std::move(read.derived), {});
    const compensation::Offsets& offsets = twin.step(0.0, twin.channels().defaults(), {});
    require(offsets.offset_um.size() == static_cast<Eigen::Index>(twin.axes().size()), "an offset for each axis");
  } catch (const core::InputError& error) {
    require(std::string_view(error.what()).size() > 0, "a message");
  }
  return 0;
}
