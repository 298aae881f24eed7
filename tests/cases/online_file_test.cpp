// SPDX-License-Identifier: GPL-3.0-or-later
// The online data that `compensate` and `serve` keep beside a model: the same answers with and without, and no file is
// believed that is damaged, of another model or beside a damaged one.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <random>
#include <thread>
#include <unistd.h>

#include "tests/cases/served.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

constexpr std::size_t head_bytes = 32, sum_at = 24, word_bytes = 8;
constexpr const char* written = "online data written to ";

double number_at(const std::string& bytes, std::size_t at) {
  double value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Online data whose largest offset is 77 um, with the right checksum: who reads them says so.
std::string marked(std::string bytes) {
  const std::string two_by_one =
      std::string("\2\0\0\0\0\0\0\0", word_bytes) + std::string("\2\0\0\0\0\0\0\0", word_bytes);
  int found = 0;
  for (std::size_t at = bytes.find(two_by_one); at != std::string::npos; at = bytes.find(two_by_one, at + word_bytes)) {
    const std::size_t place = at + two_by_one.size();
    if (place + 16 > bytes.size()) break;
    const double largest = number_at(bytes, place), rate = number_at(bytes, place + word_bytes);
    if (!(largest > 1.0) || std::abs(rate * 300.0 - largest) > 1e-9 * largest) continue;
    constexpr double mark = 77.0;
    std::memcpy(bytes.data() + place, &mark, sizeof mark);
    ++found;
  }
  EXPECT_EQ(found, 1);
  std::uint64_t sum = 0xCBF29CE484222325ULL;
  for (std::size_t at = head_bytes; at < bytes.size(); at += word_bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, word_bytes);
    sum = (sum ^ word) * 0x100000001B3ULL;
    sum ^= sum >> 29U;
  }
  std::memcpy(bytes.data() + sum_at, &sum, sizeof sum);
  return bytes;
}

constexpr const char* mark_said = "offset limits: 77 um";

class OnlineFile : public Serve {
protected:
  std::string online() const { return file("model.online"); }
  Result compensate(const std::vector<std::string>& more = {}, const Surroundings& around = {}) const {
    std::vector<std::string> words = {"compensate", model()};
    words.insert(words.end(), more.begin(), more.end());
    return thermotwin(words, rows_to(7200), around);
  }
  /// Made by a start. @return what that start answered
  std::string made() const {
    const Result first = compensate();
    EXPECT_EQ(first.status, 0) << first.err;
    EXPECT_SAYS(first.err, written + online());
    return first.out;
  }
  void mark() const { toy_.write("model.online", marked(read(online()))); }
  static void settle() { std::this_thread::sleep_for(std::chrono::milliseconds(300)); }
};

TEST_F(OnlineFile, GivesTheSameBytesAsTheModel) {
  const std::vector<std::vector<std::string>> ways = {
      {},
      {"--json-lines"},
      {"--step", "30", "--start-C", "23", "--largest-offset", "20", "--offset-rate", "0.5"},
      {"--no-sensors", "--order", "5"},
      {"--learned", file("learned"), "--lines", file("lines"), "--state", file("state")},
      {"--explain", file("explain")}};
  const std::vector<std::string> beside = {"learned", "lines", "state", "explain"};
  for (const std::vector<std::string>& way : ways) {
    const auto answers = [&] {
      std::string all;
      const Result result = compensate(way);
      EXPECT_EQ(result.status, 0) << result.err;
      for (const std::string& name : beside) {
        if (!std::filesystem::exists(file(name))) continue;
        all += read(file(name));
        std::filesystem::remove(file(name));
      }
      return result.out + all;
    };
    for (const char* name : {"model.online", "model.order5.online"}) std::filesystem::remove(file(name));
    const std::string first = answers(), second = answers();
    EXPECT_TRUE(first == second) << (way.empty() ? "" : way.front());
    EXPECT_GT(first.size(), 1000U);
  }
  EXPECT_FALSE(std::filesystem::exists(online())) << "--explain needs the whole model";
}

TEST_F(OnlineFile, IsWhatCompensateAndServeRead) {
  made();
  mark();
  EXPECT_SAYS(compensate().err, mark_said);
  EXPECT_SAYS(compensate({"--step", "30"}).err, mark_said);
  const Result other = compensate({"--order", "5"});
  EXPECT_EQ(other.err.find(mark_said), std::string::npos);
  EXPECT_SAYS(other.err, written + file("model.order5.online"));
  EXPECT_SAYS(thermotwin({"serve", model()}, rows_to(7200)).err, mark_said);
}

TEST_F(OnlineFile, OfAnotherModelIsWrittenAnew) {
  made();
  mark();
  std::filesystem::copy(toy_run() / "reference.rom.h5", file("new.rom.h5"));
  std::filesystem::rename(file("new.rom.h5"), model());
  const Result second = compensate();
  EXPECT_EQ(second.status, 0) << second.err;
  EXPECT_SAYS(second.err, "online data of another model, not used");
  EXPECT_SAYS(second.err, written + online());
  EXPECT_EQ(second.err.find(mark_said), std::string::npos);
  EXPECT_EQ(second.out, thermotwin({"compensate", (toy_run() / "reference.rom.h5").string()}, rows_to(7200)).out);
}

// The file says what the model said before it was damaged; that the model is damaged has to be said all the same.
TEST_F(OnlineFile, DoesNotHideADamagedModel) {
  for (const bool settled : {false, true}) {
    if (settled) settle();
    made();
    mark();
    EXPECT_SAYS(compensate().err, mark_said) << "and its stamp is stored";
    std::string bytes = read(model());
    bytes[bytes.size() / 2] ^= 4;
    toy_.write("model.rom.h5", bytes);
    const Result result = compensate();
    EXPECT_EQ(result.status, 3);
    EXPECT_SAYS(result.err, "wrong checksum");
    bytes[bytes.size() / 2] ^= 4;
    toy_.write("model.rom.h5", bytes);
    EXPECT_SAYS(compensate().err, mark_said) << "the model is whole again";
    std::filesystem::remove(online());
  }
}

TEST_F(OnlineFile, ThatIsDamagedIsWrittenAnew) {
  const std::string answers = made(), whole = read(online());
  std::mt19937 random(3);
  for (int flip = 0; flip < 6; ++flip) {
    std::string bytes = whole;
    bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8U);
    toy_.write("model.online", bytes);
    const Result result = compensate();
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.out, answers);
    EXPECT_SAYS(result.err, "not used");
    EXPECT_SAYS(result.err, written + online());
  }
  for (const std::size_t size : {std::size_t{0}, whole.size() / 2, whole.size() - 1}) {
    ASSERT_EQ(::truncate(online().c_str(), static_cast<off_t>(size)), 0);
    EXPECT_EQ(compensate().out, answers);
    EXPECT_EQ(read(online()).size(), whole.size());
  }
}

TEST_F(OnlineFile, LiesBesideTheStateWhereTheModelsFolderTakesNone) {
  std::filesystem::create_directory(online());  // no file can have that name
  std::filesystem::create_directory(file("states"));
  const std::vector<std::string> state = {"--state", file("states/serve.state")};
  const Result first = compensate(state);
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_SAYS(first.err, written + file("states/model.online"));
  toy_.write("states/model.online", marked(read(file("states/model.online"))));
  std::filesystem::remove(file("states/serve.state"));
  EXPECT_SAYS(compensate(state).err, mark_said);
}

TEST_F(OnlineFile, ThatCannotBeWrittenEndsNothing) {
  Surroundings full;
  full.largest_file = 4096;
  const Result result = compensate({}, full);
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "each start reads the whole model");
  EXPECT_FALSE(std::filesystem::exists(online()));
  EXPECT_EQ(result.out, made());
}

}  // namespace
}  // namespace thermotwin::cases
