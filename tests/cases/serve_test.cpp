// SPDX-License-Identifier: GPL-3.0-or-later
// `serve`: the model beside a control, with processes that die, states that are cut off, other models, clocks that
// leap, sockets and a full disk. serve_page_test.cpp has its page.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <random>
#include <sstream>

#include "tests/cases/local_socket.h"
#include "tests/cases/served.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// The cells between the offsets and the status.
std::string deviations_of(const std::string& line) {
  std::size_t begin = 0;
  for (int cell = 0; cell < 4; ++cell) begin = line.find(',', begin) + 1;
  return line.substr(begin, line.rfind(',') - begin);
}

TEST_F(Serve, GivesTheOffsetsOfCompensate) {
  const std::string rows = rows_to(7200);
  const Result served = thermotwin(arguments(), rows), alone = thermotwin({"compensate", model()}, rows);
  ASSERT_EQ(served.status, 0) << served.err;
  std::istringstream one(served.out), other(alone.out);
  std::string a, b;
  int count = 0;
  for (; std::getline(one, a); ++count) {
    ASSERT_TRUE(std::getline(other, b));
    if (count == 0) {
      EXPECT_EQ(a, b);
      continue;
    }
    const Served got = served_of(a), wanted = served_of(b);
    EXPECT_EQ(got.time, wanted.time);
    EXPECT_EQ(got.status, wanted.status);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(got.offset[k], wanted.offset[k], 0.0011) << a;
    EXPECT_EQ(deviations_of(a), deviations_of(b)) << "rounded once";
  }
  EXPECT_EQ(count, 32);
  EXPECT_TRUE(std::filesystem::exists(state()));
}

TEST_F(Serve, JsonLinesHaveTheSameNumbers) {
  std::string rows = rows_to(7200);
  for (int i = 1; i <= 20; ++i) rows += row(7200 + 0.5 * i);
  const Result csv = thermotwin(arguments(), rows);
  std::filesystem::remove(state());
  const Result lines = thermotwin(arguments({"--json-lines"}), rows);
  ASSERT_EQ(lines.status, 0) << lines.err;
  std::istringstream one(csv.out), other(lines.out);
  std::string a, b;
  std::getline(one, a);
  int whole = 0;
  while (std::getline(one, a)) {
    ASSERT_TRUE(std::getline(other, b));
    const auto json = nlohmann::json::parse(b);
    const Served got = served_of(a);
    EXPECT_EQ(json["time_s"], got.time);
    EXPECT_EQ(json["status"], got.status);
    EXPECT_NEAR(json["offset_um"]["z"], got.offset[2], 6e-4);
    EXPECT_EQ(json["axes"].size(), 3U);
    whole += json.contains("sensors");
  }
  EXPECT_FALSE(std::getline(other, b));
  EXPECT_EQ(whole, 31 + 10) << "once a second of the rows' time";
}

/// A warm machine, then rows at 20 Hz of real time; kills at random moments.
TEST_F(Serve, OffsetsGoOnWhileTheModelIsKilled) {
  Program program(arguments());
  program.write(header);
  double time = 0;
  const auto step_to = [&](double at) {
    time = at;
    program.write(row(time));
    return served_of(program.read_line());
  };
  program.write(row(time));
  EXPECT_TRUE(program.read_line().starts_with("time_s,offset_x_um"));
  program.read_line();
  while (time < 7200 - warm_step_s) step_to(time + warm_step_s);
  // Recorded rows are faster than the disk; the state of a machine in real time is at most a minute old.
  wait_s(0.5 * slowness());
  const auto written = std::filesystem::last_write_time(state());
  Served last = step_to(7200);
  for (int i = 0; i < 500 && std::filesystem::last_write_time(state()) == written; ++i) wait_s(0.02);
  const Served warm = last;
  ASSERT_GT(std::abs(warm.offset[2]), 5.0) << "something to lose";
  std::mt19937 random(7);
  const auto begin = Clock::now();
  int gone = 0;
  double longest = 0;
  const auto live_step = [&] {
    wait_s(0.05);
    const double before = time;
    const Served now = step_to(7200 + seconds_since(begin));
    for (int c = 0; c < 3; ++c)
      EXPECT_LE(std::abs(now.offset[c] - last.offset[c]), toy_rate_um_s * (time - before) + 0.0011) << time;
    last = now;
    const bool is_gone = now.status.find("model=gone") != std::string::npos;
    gone += is_gone;
    return !is_gone;
  };
  while (seconds_since(begin) < 1.5) live_step();
  for (int kill = 0; kill < 6; ++kill) {
    for (int i = std::uniform_int_distribution(1, 12)(random); i > 0; --i) live_step();
    EXPECT_EQ(kill_all("model"), 1);
    const auto killed = Clock::now();
    const int gone_before = gone;
    // A row that was taken before the kill may still be answered, and a model that is back soon misses no row.
    constexpr double unnoticed_s = 1.0;
    while (seconds_since(killed) < 10 * slowness()) {
      const bool answered = live_step();
      if (answered && (gone > gone_before || seconds_since(killed) > unnoticed_s)) break;
    }
    longest = std::max(longest, seconds_since(killed));
  }
  EXPECT_LT(longest, 2.0 * slowness());
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(last.offset[c], warm.offset[c], 0.02 * std::abs(warm.offset[2]) + 0.2);
  const Result result = program.wait();
  EXPECT_EQ(result.status, 0) << result.err;
  const std::string restart = "the model has ended (signal 9) and is started again";
  int restarts = 0;
  for (std::size_t at = result.err.find(restart); at != std::string::npos; at = result.err.find(restart, at + 1))
    ++restarts;
  EXPECT_EQ(restarts, 6);
}

// The model begins cold and wants offsets near 0; the machine gets there at the rate of the guard.
TEST_F(Serve, AStateThatIsLostMovesNoAxisByALeap) {
  Program program(arguments());
  program.write(rows_to(7200));
  Served last;
  program.read_line();
  for (int i = 0; i <= 30; ++i) last = served_of(program.read_line());
  const double warm = last.offset[2];
  ASSERT_GT(std::abs(warm), 5.0);
  toy_.write("serve.state", "of nobody");
  EXPECT_EQ(kill_all("model"), 1);
  std::string statuses;
  for (int i = 1; i <= 300; ++i) {
    const double time = 7200 + 0.1 * i;
    program.write(row(time));
    const Served now = served_of(program.read_line());
    for (int c = 0; c < 3; ++c)
      ASSERT_LE(std::abs(now.offset[c] - last.offset[c]), toy_rate_um_s * 0.1 + 0.0011) << time;
    statuses += now.status + "\n";
    last = now;
  }
  EXPECT_LT(std::abs(last.offset[2]), std::abs(warm) - 5.0) << "it moves";
  EXPECT_SAYS(statuses, "state=refused");
  EXPECT_EQ(read(state() + ".refused"), "of nobody");
  const Result result = program.wait();
  EXPECT_EQ(result.status, 0);
  EXPECT_SAYS(result.err, "cold start");
}

TEST_F(Serve, GoesOnAfterAPowerCutFromAnyPrefixOfItsState) {
  std::string last_line;
  {
    Program program(arguments());
    program.write(rows_to(7200));
    for (int line = 0; line < 32; ++line) last_line = program.read_line();
    program.send(SIGKILL);
    kill_all("model");
    program.wait();
  }
  const Served before = served_of(last_line);
  const std::string saved = read(state());
  ASSERT_GT(saved.size(), 1000U);
  for (const std::size_t size : {saved.size(), std::size_t{0}, std::size_t{20}, saved.size() / 2, saved.size() - 1}) {
    toy_.write("serve.state", saved.substr(0, size));
    const Result again = thermotwin(arguments(), header + row(7201) + row(7202));
    ASSERT_EQ(again.status, 0) << again.err;
    const std::vector<Served> answers = all_served(again.out);
    ASSERT_EQ(answers.size(), 2U) << again.out;
    if (size == saved.size()) {
      EXPECT_NEAR(answers[0].offset[2], before.offset[2], 1.0);
      EXPECT_EQ(answers[0].status.find("state="), std::string::npos) << answers[0].status;
      continue;
    }
    EXPECT_EQ(answers[0].offset[2], 0.0) << size;
    EXPECT_LE(std::abs(answers[1].offset[2]), toy_rate_um_s + 0.0011) << size;
    EXPECT_SAYS(answers[0].status, "state=refused");
    EXPECT_EQ(answers[1].status.find("state="), std::string::npos);
    EXPECT_SAYS(again.err, "cold start");
    EXPECT_EQ(read(state() + ".refused"), saved.substr(0, size));
  }
  // An hour off is computed; nobody has applied the offsets meanwhile.
  toy_.write("serve.state", saved);
  const Result later = thermotwin({"serve", model()}, header + row(10800, 0));
  EXPECT_SAYS(later.err, "since the saved state: computed as a machine that is off");
  EXPECT_EQ(all_served(later.out).at(0).offset[2], 0.0);
}

TEST_F(Serve, AControlWhoseClockBeganAnewGoesOnFromTheState) {
  const Result first = thermotwin(arguments(), rows_to(7200));
  const Served before = all_served(first.out).back();
  const Result again = thermotwin(arguments(), header + row(5) + row(6));
  EXPECT_EQ(again.status, 0) << again.err;
  const std::vector<Served> answers = all_served(again.out);
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[0].time, 5.0);
  EXPECT_SAYS(answers[0].status, "clock=back");
  EXPECT_NEAR(answers[1].offset[2], before.offset[2], 1.0);
  EXPECT_SAYS(again.err, "the clock of the rows has gone back to 5 s");
}

TEST_F(Serve, ARowWithoutATimeHasThatOfTheRowBefore) {
  std::string untimed = row(0);
  untimed.erase(0, untimed.find(','));
  const Result result = thermotwin(arguments(), header + row(1000) + row(1060) + row(500) + untimed + row(560));
  EXPECT_EQ(result.status, 0) << result.err;
  const std::vector<Served> answers = all_served(result.out);
  ASSERT_EQ(answers.size(), 5U);
  for (const auto& [i, time] : {std::pair{2, 500.0}, {3, 500.0}, {4, 560.0}}) EXPECT_EQ(answers[i].time, time) << i;
  EXPECT_SAYS(answers[3].status, "time_s=missing");
}

TEST_F(Serve, RefusesTheStateOfAnotherModel) {
  ASSERT_EQ(thermotwin(arguments({"--order", "5"}), header + row(0)).status, 0);
  const std::string other = read(state());
  const Result result = thermotwin(arguments(), header + row(60));
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_SAYS(result.err, "a state of another model");
  EXPECT_SAYS(result.err, state());
  EXPECT_EQ(read(state()), other);
  EXPECT_EQ(thermotwin(arguments({"--state", file("own.state")}), header + row(60)).status, 0);
}

TEST_F(Serve, ASecondInstanceIsRefusedAndTheFirstGoesOn) {
  Program first(arguments());
  first.write(header + row(0));
  first.read_line();
  first.read_line();
  const Result second = thermotwin(arguments(), header + row(0));
  EXPECT_EQ(second.status, 3) << second.err;
  EXPECT_SAYS(second.err, "another `serve` goes on from this state");
  first.write(row(60));
  EXPECT_EQ(served_of(first.read_line()).time, 60.0);
  EXPECT_EQ(first.wait().status, 0);
}

TEST_F(Serve, AClockThatLeapsEndsNothing) {
  std::string rows = header;
  const double day = 86400.0;
  const auto clock = [&](int i) { return warm_step_s * i + (i > 25 ? 40 * day : i > 20 ? -3600.0 : 0.0); };
  for (int i = 0; i <= 30; ++i) rows += row(clock(i));
  const Result result = thermotwin(arguments(), rows);
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "the clock of the rows has gone back to 1440 s; time goes on at 5040 s");
  EXPECT_SAYS(result.err, "the clock of the rows has gone ahead to 3462240 s; time goes on at 6240 s");
  const std::vector<Served> answers = all_served(result.out);
  ASSERT_EQ(answers.size(), 31U);
  for (int i = 0; i <= 30; ++i) {
    const Served& answer = answers[static_cast<std::size_t>(i)];
    EXPECT_EQ(answer.time, clock(i)) << "as the row states it";
    const std::string leap = i == 21 ? "clock=back" : i == 26 ? "clock=ahead" : "";
    EXPECT_EQ(answer.status.find("clock="), leap.empty() ? std::string::npos : answer.status.find(leap)) << i;
    if (i > 10) {
      EXPECT_NEAR(answer.offset[2], answers[static_cast<std::size_t>(i) - 1].offset[2], 3.0);
    }
  }
  EXPECT_EQ(result.err.find("started again"), std::string::npos) << "the model sees a time that rises";
}

// Rows that keep pace with the computer come from a running machine: a leap of an hour is summer time.
TEST_F(Serve, AnHourThatTheComputerDoesNotKnowIsTheClocks) {
  Program program(arguments());
  program.write(header);
  const auto begin = Clock::now();
  Served last;
  while (seconds_since(begin) < 3.5) {
    program.write(row(seconds_since(begin)));
    if (last.status.empty()) program.read_line();
    last = served_of(program.read_line());
    EXPECT_EQ(last.status.find("clock="), std::string::npos) << last.status;
    wait_s(0.05);
  }
  program.write(row(seconds_since(begin) + 3600));
  EXPECT_SAYS(served_of(program.read_line()).status, "clock=ahead");
  program.write(row(seconds_since(begin) + 3600.1));
  EXPECT_EQ(served_of(program.read_line()).status.find("clock="), std::string::npos);
  EXPECT_EQ(program.wait().status, 0);
  // The same leap in rows that come as fast as they are read is a machine that said nothing for an hour.
  std::filesystem::remove(state());
  const Result fast = thermotwin(arguments(), header + row(0) + row(1) + row(3601));
  EXPECT_EQ(fast.out.find("clock="), std::string::npos) << fast.out;
}

TEST_F(Serve, AnUnreadableCellIsNamed) {
  const Result result = thermotwin(arguments(), header + row(0) + "60,fast,10,20.5,20.5,20.4,20.3,20.6\n\nnonsense\n" +
                                                    row(120) + "nan,6000,10,20.5,20.5,20.4,20.3,20.6\n" + row(180));
  EXPECT_EQ(result.status, 0) << result.err;
  const std::vector<Served> answers = all_served(result.out);
  ASSERT_EQ(answers.size(), 6U) << result.out;
  EXPECT_SAYS(answers[1].status, "input_missing spindle.speed_rpm=unreadable");
  EXPECT_SAYS(answers[2].status, "row=unreadable");
  EXPECT_SAYS(answers[4].status, "time_s=missing");
  EXPECT_EQ(answers[5].time, 180.0);
  EXPECT_EQ(answers[5].status.find("input_missing"), std::string::npos);
  EXPECT_SAYS(result.err, "'fast'");
}

TEST_F(Serve, ANanIsNamedAndHasAStatusAfterFiveMinutes) {
  std::string rows = header + row(0);
  for (int minute = 1; minute <= 7; ++minute) rows += fmt::format("{},nan,10,20.5,20.5,20.4,20.3,20.6\n", 60 * minute);
  const Result result = thermotwin(arguments(), rows + row(480));
  EXPECT_EQ(result.status, 0) << result.err;
  const std::vector<Served> answers = all_served(result.out);
  ASSERT_EQ(answers.size(), 9U) << result.out;
  EXPECT_EQ(answers[5].status.find("input_missing"), std::string::npos);
  EXPECT_SAYS(answers[6].status, "input_missing");
  EXPECT_EQ(answers[8].status.find("input_missing"), std::string::npos);
  EXPECT_SAYS(result.err, "spindle.speed_rpm is nan; this counts as a blank cell");
  EXPECT_SAYS(result.err, "spindle.speed_rpm has had no value for more than 300 s");
}

TEST_F(Serve, ALineThatIsTooLongEndsNothing) {
  const auto with_line = [&](std::size_t length) {
    return thermotwin(arguments(), header + row(0) + std::string(length, '7') + "\n" + row(60));
  };
  for (const std::size_t length : {300000UL, 3000000UL}) {
    const Result result = with_line(length);
    EXPECT_EQ(result.status, 0) << result.err;
    const std::vector<Served> answers = all_served(result.out);
    ASSERT_EQ(answers.size(), 3U) << result.out;
    EXPECT_SAYS(answers[1].status, "row=unreadable");
    EXPECT_EQ(answers[2].time, 60.0);
    EXPECT_EQ(result.out.find("model=gone"), std::string::npos) << result.out;
    EXPECT_SAYS(result.err, "a line of more than");
    std::filesystem::remove(state());
  }
  EXPECT_SAYS(with_line(20000000).err, "its sender is not heard any more");
}

TEST_F(Serve, AFullDiskEndsNoControl) {
  Surroundings full;
  full.largest_file = 1000;
  std::string rows = header;
  for (int minute = 0; minute <= 10; ++minute) rows += row(60.0 * minute);
  const Result result = thermotwin(arguments(), rows, full);
  const std::vector<Served> answers = all_served(result.out);
  ASSERT_EQ(answers.size(), 11U) << result.err;
  EXPECT_SAYS(answers.back().status, "state=unwritten");
  EXPECT_SAYS(result.err, "warning: " + state());
  EXPECT_EQ(result.err.find("started again"), std::string::npos) << result.err;
  EXPECT_FALSE(std::filesystem::exists(state()));
}

// reference.rom.h5 is another model of the same machine.
TEST_F(Serve, ANewModelIsTakenOverWithoutAJumpAndABrokenOneIsNot) {
  Program program({"serve", model()});
  program.write(header + row(0));
  program.read_line();
  Served last = served_of(program.read_line());
  double time = 0;
  std::string statuses;
  const auto run = [&](int rows, double step) {
    for (int i = 0; i < rows; ++i) {
      time += step;
      program.write(row(time));
      const Served now = served_of(program.read_line());
      for (int c = 0; c < 3; ++c)
        EXPECT_LE(std::abs(now.offset[c] - last.offset[c]), toy_rate_um_s * step + 0.0011) << time;
      statuses += now.status + "\n";
      last = now;
    }
  };
  run(30, warm_step_s);
  const Served before = last;
  ASSERT_GT(std::abs(before.offset[2]), 5.0);
  const auto replace = [&](const std::filesystem::path& with) {
    std::filesystem::copy_file(with, file("new"), std::filesystem::copy_options::overwrite_existing);
    std::filesystem::rename(file("new"), model());
    // Rows go on meanwhile, a tenth of a second apart.
    statuses.clear();
    const auto begin = Clock::now();
    while (seconds_since(begin) < 20 * slowness() && statuses.find("model=new") == std::string::npos &&
           (seconds_since(begin) < 3 || with.extension() == ".h5")) {
      run(1, 0.1);
      wait_s(0.02);
    }
  };
  toy_.write("broken.rom", "no model");
  replace(file("broken.rom"));
  EXPECT_EQ(statuses.find("model="), std::string::npos) << statuses;
  replace(toy_run() / "reference.rom.h5");
  EXPECT_NE(statuses.find("model=new"), std::string::npos);
  EXPECT_EQ(statuses.find("model=gone"), std::string::npos) << "the one in use goes on until then";
  run(8, warm_step_s);
  // Cold, the new model would begin at 0; it knows the same two hours.
  const Result alone =
      thermotwin({"compensate", (toy_run() / "reference.rom.h5").string()}, rows_to(7200 + 8 * warm_step_s));
  const Served wanted = served_of(last_line_of(alone.out));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(last.offset[c], wanted.offset[c], 0.03 * std::abs(wanted.offset[2]) + 0.1);
  // And a third one, while the second saves to the file of its own takeover.
  replace(toy_run() / "model.rom.h5");
  EXPECT_NE(statuses.find("model=new"), std::string::npos);
  run(2, warm_step_s);
  // The new one goes on from its own state, too.
  EXPECT_EQ(kill_all("model"), 1);
  const auto killed = Clock::now();
  do {
    run(1, 0.1);
  } while (last.status.find("model=gone") != std::string::npos && seconds_since(killed) < 10);
  const Result result = program.wait();
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "is not taken over: ");
  EXPECT_SAYS(result.err, "is taken over");
  EXPECT_TRUE(std::filesystem::exists(state() + ".before"));
  EXPECT_FALSE(std::filesystem::exists(state() + ".next"));
  EXPECT_FALSE(std::filesystem::exists(state() + ".next2"));
  EXPECT_EQ(result.err.find("another process goes on from this state"), std::string::npos) << result.err;
  const Result again = thermotwin(arguments(), header + row(time + 60));
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_GT(std::abs(all_served(again.out).at(0).offset[2]), 5.0) << "goes on from the new model's state";
}

TEST_F(Serve, ASocketHasOneClientAtATime) {
  const std::string path = file("twin.socket");
  Program program(arguments({"--socket", path}));
  {
    const Socket first(path);
    first.send(header + row(0));
    EXPECT_TRUE(first.line().starts_with("time_s,"));
    EXPECT_EQ(served_of(first.line()).time, 0.0);
    const Socket second(path);
    EXPECT_EQ(second.line(), "another client sends rows");
  }
  {
    const Socket third(path);
    third.send(header + row(60));
    EXPECT_TRUE(third.line().starts_with("time_s,"));
    EXPECT_EQ(served_of(third.line()).time, 60.0);
  }
  {
    const Socket wrong(path);
    wrong.send("time_s,spindel.speed_rpm\n0,0\n");
    const std::string refusal = wrong.line();
    EXPECT_SAYS(refusal, "unknown column 'spindel.speed_rpm'");
    EXPECT_TRUE(refusal.starts_with("rows of " + path + ":1")) << refusal;
    EXPECT_EQ(wrong.line(), "");
  }
  {
    const Socket other(path);
    other.send("time_s,spindle.speed_rpm\n90,6000\n");
    EXPECT_TRUE(other.line().starts_with("time_s,"));
    EXPECT_EQ(served_of(other.line()).time, 90.0) << "other columns";
  }
  {
    // One that takes no answers is given up, and does not hold up who comes next.
    const Socket slow(path);
    std::string rows = "time_s,spindle.speed_rpm\n";
    for (int i = 0; i < 20000; ++i) rows += fmt::format("{},6000\n", 100 + i);
    slow.send(rows);
    const Socket next(path);
    std::string line = next.line();
    for (int i = 0; i < 50 && line == "another client sends rows"; ++i) {
      wait_s(0.1);
      const Socket again(path);
      again.send("time_s,spindle.speed_rpm\n90000,6000\n");
      line = again.line();
    }
    EXPECT_TRUE(line.starts_with("time_s,")) << line;
  }
  program.send(SIGTERM);
  EXPECT_TRUE(program.ends_within(8));
  const Result result = program.wait();
  EXPECT_EQ(result.status, 130);
  EXPECT_SAYS(result.err, "does not take its answers");
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(Serve, ASocketWaitsForNoModelThatHangs) {
  const std::string path = file("twin.socket");
  Program program(arguments({"--socket", path}));
  const Socket client(path);
  client.send(header + row(0));
  client.line();
  client.line();
  // The rows' clock is far ahead of the computer's, as after it was set.
  double time = 0.0;
  const auto answer = [&] {
    time += 1.0;
    client.send(row(time));
    return served_of(client.line());
  };
  for (int i = 0; i < 60; ++i) answer();
  ASSERT_EQ(signal_all("model", SIGSTOP), 1);
  const auto begin = Clock::now();
  EXPECT_SAYS(answer().status, "model=late");
  EXPECT_LT(seconds_since(begin), 2.0 * slowness());
  signal_all("model", SIGCONT);
  program.send(SIGTERM);
  EXPECT_TRUE(program.ends_within(8));
}

TEST_F(Serve, TheFrontNeedsNoLibraryOfTheModel) {
  const std::filesystem::path front = std::filesystem::path(THERMOTWIN_PROGRAM).parent_path() / "thermotwin_front";
  FILE* listing = ::popen(("ldd " + front.string()).c_str(), "r");
  ASSERT_NE(listing, nullptr);
  std::string libraries;
  for (int c = std::fgetc(listing); c != EOF; c = std::fgetc(listing)) libraries += static_cast<char>(c);
  ASSERT_EQ(::pclose(listing), 0);
  EXPECT_SAYS(libraries, "libc.so");
  for (const char* library : {"hdf5", "vtk", "cholmod", "blas", "lapack", "assimp", "gmsh", "httplib", "ssl"})
    EXPECT_EQ(libraries.find(library), std::string::npos) << library;
  EXPECT_LE(std::count(libraries.begin(), libraries.end(), '\n'), 8) << libraries;
}

TEST_F(Serve, BadInputAtTheStartIsRefused) {
  const auto refused = [&](const std::vector<std::string>& words, const std::string& rows, int status,
                           const std::string& says) {
    const Result result = thermotwin(words, rows);
    EXPECT_EQ(result.status, status) << result.err;
    EXPECT_SAYS(result.err, says);
    EXPECT_EQ(result.out, "");
  };
  refused(arguments(), "time_s,spindel.speed_rpm\n0,0\n", 3, "unknown column 'spindel.speed_rpm'");
  refused({"serve", file("none.rom.h5")}, "", 3, "none.rom.h5");
  toy_.write("broken.rom.h5", "no model");
  refused({"serve", file("broken.rom.h5")}, header + row(0), 3, "broken.rom.h5");
  refused(arguments({"--json"}), "", 2, "--json-lines");
  refused(arguments({"--out", "offsets.csv"}), "", 2, "--out");
  refused(arguments({"--socket", file(std::string(200, 's'))}), "", 3, "--socket");
}

}  // namespace
}  // namespace thermotwin::cases
