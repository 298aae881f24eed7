// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/online_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <sstream>

#include "compensation/control/control_bytes.h"
#include "compensation/control/online_file.h"
#include "core/error.h"
#include "tests/compensation/control/twin_of_lumps.h"
#include "tests/compensation/scratch.h"

namespace thermotwin::compensation {
namespace {

constexpr std::size_t head_bytes = 32, sum_at = 24;

const OnlineKey& lumps_key() {
  static const OnlineKey key = {"a build", "a line", {1, 2, 3, 4}, 7};
  return key;
}

const OnlineData& stored_lumps() {
  static const OnlineData data = [] {
    OnlineData made{test::lumps_with_lines(), {}};
    made.model.system.capacity.diagonal().array() += 0.5;
    made.model.errors.push_back({"a load", 9.0, 0.5, 0.25, 0.0, 1.0});
    made.derived = derived_data(made.model, ControlOptions().tolerance);
    return made;
  }();
  return data;
}

const std::string& lumps_bytes() {
  static const std::string bytes = online_bytes(lumps_key(), stored_lumps());
  return bytes;
}

OnlineData read_bytes(const std::string& bytes) {
  std::istringstream in(bytes);
  return OnlineReader(in, "lumps.online").read("lumps.rom.h5");
}

/// What somebody would write who knows the checksum.
std::string sealed(std::string bytes) {
  const std::uint64_t sum = online_sum(std::string_view(bytes).substr(head_bytes));
  std::memcpy(bytes.data() + sum_at, &sum, sizeof sum);
  return bytes;
}

/// Where the words lie one after the other.
std::size_t place_of(const std::string& bytes, const std::string& words) {
  const std::size_t at = bytes.find(words);
  EXPECT_NE(at, std::string::npos);
  return at;
}
template <class... Values>
std::string words_of(Values... values) {
  std::string words;
  (words.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
  return words;
}

void expect_refused(const std::string& bytes, const std::string& why) {
  test::expect_input_error([&] { read_bytes(bytes); }, {"lumps.online", why.c_str()});
}

TEST(OnlineData, GiveTheDataOfTheModelToTheLastBit) {
  std::istringstream in(lumps_bytes());
  OnlineReader reader(in, "lumps.online");
  EXPECT_EQ(reader.key().program, lumps_key().program);
  EXPECT_EQ(reader.key().model_line, lumps_key().model_line);
  EXPECT_EQ(reader.key().model_stamp, lumps_key().model_stamp);
  EXPECT_EQ(reader.key().order, lumps_key().order);
  OnlineData read = reader.read("lumps.rom.h5");
  EXPECT_TRUE(read.model.system.terms.empty());
  ASSERT_FALSE(stored_lumps().model.system.capacity.isIdentity()) << "a capacity that has to be stored";
  ControlOptions options;
  options.compensator.step_s = 30.0;
  options.compensator.largest_um = 12.0;
  options.compensator.rate_um_s = 0.5;
  for (const ControlOptions& each : {ControlOptions(), options}) {
    const OnlineData again = read_bytes(lumps_bytes());
    EXPECT_TRUE(control_bytes(control_data(again.model, again.derived, each)) ==
                control_bytes(control_data(stored_lumps().model, each)));
  }
  EXPECT_TRUE(online_bytes(lumps_key(), read) == lumps_bytes());
}

TEST(OnlineData, AnyFlippedBitIsAnError) {
  std::mt19937 random(5);
  for (int flip = 0; flip < 500; ++flip) {
    std::string bytes = lumps_bytes();
    bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8U);
    EXPECT_THROW(read_bytes(bytes), core::InputError) << "flip " << flip;
  }
}

TEST(OnlineData, WhatIsCutOffOrLongerIsAnError) {
  for (std::size_t size = 0; size < lumps_bytes().size(); size += 1 + lumps_bytes().size() / 97)
    EXPECT_THROW(read_bytes(lumps_bytes().substr(0, size)), core::InputError) << size;
  expect_refused(lumps_bytes() + std::string(8, '\0'), "cut off");
  expect_refused("no data", "no online data");
  std::string other = lumps_bytes();
  other[8] = 9;
  expect_refused(other, "version 9");
  other = lumps_bytes();
  other[head_bytes + 60] ^= 1;
  expect_refused(other, "wrong checksum");
}

// With the right checksum: by somebody else's program, or by a fault of ours.
TEST(OnlineData, SizesAndNumbersThatDisagreeAreRefused) {
  const reduction::ReducedModel& model = stored_lumps().model;
  const OffsetLimits& limits = stored_lumps().derived.limits;
  const auto with = [&](const std::string& words, std::size_t skip, const std::string& instead) {
    std::string bytes = lumps_bytes();
    bytes.replace(place_of(bytes, words) + skip, instead.size(), instead);
    return sealed(bytes);
  };
  const std::string guard = words_of(limits.largest_um, limits.rate_um_s);
  ASSERT_TRUE(sealed(lumps_bytes()) == lumps_bytes());
  expect_refused(with(guard, 0, words_of(std::numeric_limits<double>::quiet_NaN())), "not finite");
  expect_refused(with(guard, 8, words_of(-1.0)), "limits of offsets");
  const std::int64_t order = model.system.order();
  expect_refused(with(words_of(order, order * order, model.system.conduction(0, 0)), 0, words_of(order * order)),
                 "the conduction");
  expect_refused(with(words_of(order, order, model.system.one_kelvin[0]), 8, words_of(order + 1)), "cut off");
  const std::vector<std::int32_t>& first = stored_lumps().derived.term_first;
  expect_refused(with(words_of(std::int64_t(first.size()), first[0], first[1]), 8, words_of(first[1], first[1])),
                 "terms");
  expect_refused(with(words_of(std::int64_t(first.size()), first[0], first[1]), 0, words_of(std::int64_t(-1))),
                 "beyond its end");
  const solver::JointGrid& grid = model.system.layout.grids[0];
  const auto nodes = static_cast<std::int32_t>(grid.positions.size());
  expect_refused(with(words_of(std::int32_t(grid.axis), std::int32_t(grid.periodic), nodes), 8, words_of(nodes + 1)),
                 "grids of joints");
  expect_refused(with(words_of(std::int64_t(7)), 0, words_of(std::int64_t(8))).substr(0, 100), "cut off");
}

TEST(OnlineData, NumbersThatAreNotFiniteAreNotStored) {
  OnlineData data = stored_lumps();
  EXPECT_TRUE(can_be_stored(data));
  data.derived.limits.rapid[0] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(can_be_stored(data));
}

TEST(OnlineFile, LiesBesideItsModel) {
  EXPECT_EQ(online_file({"out/model.rom.h5", 0, {}}), "out/model.online");
  EXPECT_EQ(online_file({"reference.rom.h5", 60, {}}), "reference.order60.online");
  EXPECT_EQ(online_file({"out/mine.h5", 0, {}}), "out/mine.online");
}

}  // namespace
}  // namespace thermotwin::compensation
