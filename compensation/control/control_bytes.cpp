// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/control_bytes.h"

#include <cstring>
#include <vector>

#include "compensation/control/model_bytes.h"

namespace thermotwin::compensation {
namespace {

class Bytes {
public:
  template <class Value>
  void add(const std::vector<Value>& values) {
    count(values.size());
    raw(values.data(), values.size() * sizeof(Value));
  }
  void add(const std::vector<std::string>& values) {
    std::string all;
    for (const std::string& value : values) all += value + '\0';
    count(values.size());
    count(all.size());
    raw(all.data(), all.size());
    texts_ += values.size();
  }
  /// @return the whole with its head
  std::string with_head(std::uint64_t hash) const {
    tt_model_head head{};
    std::memcpy(head.magic, TT_MODEL_MAGIC, sizeof head.magic);
    head.version = TT_MODEL_VERSION;
    head.hash = hash;
    head.bytes = sizeof head + bytes_.size();
    head.texts = texts_;
    head.sum = tt_model_sum(bytes_.data(), bytes_.size());
    std::string whole(sizeof head, '\0');
    std::memcpy(whole.data(), &head, sizeof head);
    return whole + bytes_;
  }

private:
  void count(std::uint64_t value) { raw(&value, sizeof value); }
  void raw(const void* from, std::size_t size) {
    const std::size_t before = bytes_.size();
    bytes_.resize(before + (size + 7) / 8 * 8, '\0');
    if (size > 0) std::memcpy(bytes_.data() + before, from, size);
  }
  std::string bytes_;
  std::uint64_t texts_ = 0;
};

}  // namespace

std::string control_bytes(const ControlData& data) {
  Bytes bytes;
  bytes.add(std::vector<std::string>{data.name});
  std::vector<std::int32_t> counts;
#define TT_FIELD(x) counts.push_back(data.x);
  TT_MODEL_COUNTS(TT_FIELD)
#undef TT_FIELD
  bytes.add(counts);
  std::vector<double> numbers;
#define TT_FIELD(x) numbers.push_back(data.x);
  TT_MODEL_NUMBERS(TT_FIELD)
#undef TT_FIELD
  bytes.add(numbers);
#define TT_FIELD(x) bytes.add(data.x);
  TT_MODEL_DOUBLES(TT_FIELD)
  TT_MODEL_INTS(TT_FIELD)
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
  return bytes.with_head(data.hash);
}

}  // namespace thermotwin::compensation
