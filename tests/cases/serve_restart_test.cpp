// SPDX-License-Identifier: GPL-3.0-or-later
// `serve` beside a control that stays on while `serve` starts again: rows and offsets that it keeps, and clocks
// that leap right after the start.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>

#include "core/file.h"
#include "tests/cases/local_socket.h"
#include "tests/cases/served.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using Clock = std::chrono::steady_clock;

/// A client of the socket that sends a row and waits for its answer.
class Control {
public:
  Control(const std::string& socket, const std::string& header) : socket_(socket) { socket_.send(header); }

  /// Warns of an offset that has moved faster than its rate since the answer before.
  Served ask(const std::string& row) {
    const auto now = Clock::now();
    socket_.send(row);
    std::string line = socket_.line();
    if (line.starts_with("time_s,")) line = socket_.line();
    const Served answer = served_of(line);
    if (has_last_) {
      const double passed = std::chrono::duration<double>(now - asked_).count();
      // The front takes the second of two rows somewhat later than the first, at most by the time of its answer.
      const double late = std::chrono::duration<double>(Clock::now() - now).count();
      for (int c = 0; c < 3; ++c)
        EXPECT_LE(std::abs(answer.offset[c] - last_.offset[c]), toy_rate_um_s * (passed + late) + 0.0021) << line;
    }
    asked_ = now;
    has_last_ = true;
    return last_ = answer;
  }

private:
  Socket socket_;
  Clock::time_point asked_;
  Served last_;
  bool has_last_ = false;
};

class ServeRestart : public Serve {
protected:
  ServeRestart() {
    const Result warm = thermotwin(arguments(), rows_to(7200));
    EXPECT_EQ(warm.status, 0) << warm.err;
    warm_ = served_of(last_line_of(warm.out));
    EXPECT_GT(std::abs(warm_.offset[2]), 5.0);
  }
  std::string socket() const { return file("twin.socket"); }
  std::string last_offsets() const { return state() + ".offsets"; }

  /// Rows of 0.1 s until the new model is in use. @return all statuses
  std::string take_over_new_model(Program& program, double& time, double longest_s) {
    std::filesystem::copy_file(toy_run() / "reference.rom.h5", file("new"),
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::rename(file("new"), model());
    std::string statuses;
    const auto begin = Clock::now();
    while (std::chrono::duration<double>(Clock::now() - begin).count() < longest_s &&
           statuses.find("model=new") == std::string::npos) {
      time += 0.1;
      program.write(row(time));
      statuses += served_of(program.read_line()).status + "\n";
      wait_s(0.02);
    }
    return statuses;
  }

  Served warm_;
};

TEST_F(ServeRestart, ANewModelKnowsTheRowsBeforeTheRestart) {
  Program program({"serve", model()});
  double time = 7260;
  program.write(header + row(time));
  program.read_line();
  program.read_line();
  EXPECT_SAYS(take_over_new_model(program, time, 20 * slowness()), "model=new");
  Served last;
  for (int i = 0; i < 8; ++i) {
    time += warm_step_s;
    program.write(row(time));
    last = served_of(program.read_line());
  }
  EXPECT_EQ(program.wait().status, 0);
  const Result alone =
      thermotwin({"compensate", (toy_run() / "reference.rom.h5").string()}, rows_to(7200 + 8 * warm_step_s));
  const Served wanted = served_of(last_line_of(alone.out));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(last.offset[c], wanted.offset[c], 0.05 * std::abs(wanted.offset[2]) + 0.2);
}

// A night of the machine between: the new model computes it as the other one did.
TEST_F(ServeRestart, ANewModelComputesThePauseBetween) {
  Program program({"serve", model()});
  double time = 7200 + 6 * 3600;
  program.write(header + row(time, 0));
  program.read_line();
  program.read_line();
  EXPECT_SAYS(take_over_new_model(program, time, 20 * slowness()), "model=new");
  const Result result = program.wait();
  EXPECT_EQ(result.status, 0);
  std::size_t pauses = 0;
  const std::string computed = "computed as a machine that is off";
  for (std::size_t at = result.err.find(computed); at != std::string::npos; at = result.err.find(computed, at + 1))
    ++pauses;
  EXPECT_EQ(pauses, 2U) << result.err;
}

TEST_F(ServeRestart, WithoutTheRowsBeforeTheModelInUseGoesOn) {
  std::filesystem::remove(state() + ".rows");
  Program program({"serve", model()});
  double time = 7260;
  program.write(header + row(time));
  program.read_line();
  program.read_line();
  const std::string statuses = take_over_new_model(program, time, 4.0);
  EXPECT_EQ(statuses.find("model=new"), std::string::npos);
  EXPECT_SAYS(statuses, "model=waits");
  program.write(row(time + 10));
  EXPECT_NEAR(served_of(program.read_line()).offset[2], warm_.offset[2], 1.0);
  // A model process that is started again has to take the new file, and says that it is cold.
  EXPECT_EQ(kill_all("model"), 1);
  bool is_cold = false;
  for (int i = 0; i < 200 && !is_cold; ++i) {
    program.write(row(time + 10.1 + 0.1 * i));
    is_cold = served_of(program.read_line()).status.find("model=cold") != std::string::npos;
    wait_s(0.02);
  }
  EXPECT_TRUE(is_cold);
  const Result result = program.wait();
  EXPECT_SAYS(result.err, "the model in use goes on");
}

TEST_F(ServeRestart, ADamagedFileOfRowsIsReadBehindTheDamage) {
  const std::string rows = read(state() + ".rows");
  toy_.write("serve.state.rows", rows.substr(0, rows.size() / 2) + "#" + rows.substr(rows.size() / 2 + 1));
  const Result result = thermotwin(arguments(), header + row(7260));
  EXPECT_EQ(result.status, 0);
  EXPECT_SAYS(result.err, ".rows is damaged; 16 rows of it are used");
}

TEST_F(ServeRestart, AClockThatLeapsRightAfterTheStartMovesNoOffsetByALeap) {
  for (const int rows : {1, 4}) {
    Program program(arguments({"--socket", socket()}));
    {
      Control control(socket(), header);
      const auto begin = Clock::now();
      const auto now_s = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
      const double start = 7205 + 100 * rows;
      for (int i = 0; i < rows; ++i) {
        EXPECT_EQ(control.ask(row(start + now_s(), 0)).status.find("clock="), std::string::npos);
        wait_s(0.1);
      }
      EXPECT_SAYS(control.ask(row(start + now_s() + 3600, 0)).status, "clock=ahead") << rows;
      for (int i = 0; i < 5; ++i) {
        wait_s(0.1);
        EXPECT_EQ(control.ask(row(start + now_s() + 3600, 0)).status.find("clock="), std::string::npos);
      }
    }
    program.send(SIGTERM);
    program.wait();
  }
}

TEST_F(ServeRestart, OtherColumnsAreSaidAndHoldTheOffsets) {
  Program program({"serve", model(), "--socket", socket()});
  Served last;
  const auto begin = Clock::now();
  const auto now_s = [&] { return 7205 + std::chrono::duration<double>(Clock::now() - begin).count(); };
  {
    Control control(socket(), header);
    while (now_s() < 7207.5) {
      last = control.ask(row(now_s()));
      wait_s(0.1);
    }
  }
  {
    Control control(socket(), "time_s,spindle.speed_rpm,air.T_C\n");
    for (int i = 0; i < 20; ++i) {
      const Served now = control.ask(fmt::format("{},6000,20.5\n", now_s()));
      EXPECT_NEAR(now.offset[2], last.offset[2], 0.5) << i;
      // A start may be quicker than the patience of a row.
      EXPECT_EQ(now.status.find("model="), now.status.find("model=columns")) << now.status;
      wait_s(0.05);
    }
  }
  program.send(SIGTERM);
  EXPECT_SAYS(program.wait().err, "the rows have other columns than before");
}

// The control stays on while the state is lost: it sees its offsets move at their rate, from where they were.
TEST_F(ServeRestart, WithoutAStateTheOffsetsGoOnFromTheLastOnes) {
  Served last;
  const auto live = [&](double time, double pace, int rows) {
    Control control(socket(), header);
    Served first;
    for (int i = 0; i < rows; ++i) {
      last = control.ask(row(time + pace * 0.1 * i));
      if (i == 0) first = last;
      wait_s(0.1);
    }
    return first;
  };
  {
    Program program(arguments({"--socket", socket()}));
    live(7205, 1.0, 12);
    program.send(SIGKILL);
    kill_all("model");
    program.wait();
  }
  const Served before = last;
  ASSERT_GT(std::abs(before.offset[2]), 5.0);
  toy_.write("serve.state", "of nobody");
  const std::string kept = read(last_offsets());
  {
    Program program(arguments({"--socket", socket()}));
    // Rows fifty times as fast as the computer's time make no axis faster.
    const Served first = live(7210, 50.0, 15);
    EXPECT_SAYS(first.status, "state=refused");
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(first.offset[c], before.offset[c], 3.0);
    EXPECT_LT(std::abs(last.offset[2]), std::abs(first.offset[2]) - 1.0) << "they move";
    program.send(SIGTERM);
    program.wait();
  }
  // Damaged, or of long ago: from 0.
  auto kept_json = nlohmann::json::parse(kept.substr(0, kept.find('\n')));
  kept_json["boot_s"] = double{kept_json["boot_s"]} - 400.0;
  const std::string old = kept_json.dump();
  for (const std::string& offsets : {kept.substr(0, kept.size() / 2), std::string(kept.size(), '\0'), std::string(),
                                     old + "\n" + core::content_hash(old) + "\n"}) {
    std::filesystem::remove(state());
    toy_.write("serve.state.offsets", offsets);
    Program program(arguments({"--socket", socket()}));
    EXPECT_EQ(live(7300, 1.0, 1).offset[2], 0.0) << offsets;
    program.send(SIGTERM);
    program.wait();
  }
  std::filesystem::remove(state());
  toy_.write("serve.state.offsets", kept);
  Program program(arguments({"--socket", socket()}));
  EXPECT_NEAR(live(7300, 1.0, 1).offset[2], before.offset[2], 3.0) << "the same file, whole and young";
  program.send(SIGTERM);
  program.wait();
}

}  // namespace
}  // namespace thermotwin::cases
