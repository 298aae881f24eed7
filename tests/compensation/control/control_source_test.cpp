// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/control_source.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>
#include <sstream>
#include <sys/wait.h>

#include "core/file.h"
#include "tests/compensation/control/twin_of_lumps.h"
#include "tests/compensation/scratch.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::VectorXd;

struct Said {
  int status;
  std::string text;
};

Said run(const std::string& command) {
  Said said{-1, {}};
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return said;
  std::array<char, 4096> part{};
  for (std::size_t count = 0; (count = fread(part.data(), 1, part.size(), pipe)) > 0;)
    said.text.append(part.data(), count);
  said.status = pclose(pipe);
  return said;
}

bool has_program(const std::string& name) { return run("command -v " + name).status == 0; }

const reduction::ReducedModel& lumps() {
  static const reduction::ReducedModel model = test::lumps_with_lines();
  return model;
}

double time_of(int i) { return i % 500 < 350 ? 0.5 * i : 0.5 * i + 40.0 * (i % 500 - 350); }

VectorXd row_of(const solver::Channels& channels, int i) {
  const double time = time_of(i);
  VectorXd row = test::working_row(lumps().machine, channels, test::shift_row(channels, time + 1.0), time);
  if (i % 7 == 3) row.setConstant(solver::not_given);
  return row;
}

/// Readings that wander, some missing; the second sensor fails.
VectorXd readings_of(int i) {
  VectorXd readings(std::ssize(lumps().machine.sensors));
  for (Eigen::Index s = 0; s < readings.size(); ++s)
    readings[s] = (i + s) % 11 == 0 ? solver::not_given
                                    : 20.0 + 0.1 * static_cast<double>(s) + 3.0 * std::sin(time_of(i) / 5000.0);
  if (i > 900) readings[1] = 21.5;
  return readings;
}

/// Rows of CSV that keep all bits, rising in time.
std::string csv(int rows) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  std::string text = "time_s";
  for (const std::string& name : operating.channels().names()) text += "," + name;
  for (const mesh::SensorSpec& sensor : lumps().machine.sensors) text += "," + sensor.id + "_C";
  text += "\n";
  for (int i = 0; i < rows; ++i) {
    text += fmt::format("{}", time_of(i) + 1e4 * (i / 500));
    for (const VectorXd& values : {row_of(operating.channels(), i), readings_of(i)}) {
      for (const double value : values) text += std::isnan(value) ? std::string(",") : fmt::format(",{}", value);
    }
    text += "\n";
  }
  return text;
}

/// What the example prints for these rows, by the core in this process.
std::string expected(const tt_model& model, int rows) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  test::Twin twin(model);
  std::string text = "time_s,offset_X_um,offset_Y_um,offset_Z_um,std_X_um,std_Y_um,std_Z_um,status\n";
  std::array<char, 64> number{};
  const auto add = [&](const char* format, double value) {
    std::snprintf(number.data(), number.size(), format, value);
    text += number.data();
  };
  for (int i = 0; i < rows; ++i) {
    const double time = time_of(i) + 1e4 * (i / 500);
    const int status = twin.row(time, row_of(operating.channels(), i), readings_of(i));
    add("%.17g", time);
    for (const double offset : twin.offset_um()) add(",%a", offset);
    for (const double std : twin.std_um()) add(",%a", std);
    text += std::string(",") + tt_status_text(status);
    for (int s = 0; s < model.sensors && status == TT_SENSOR_FAILED; ++s) {
      if (tt_twin_sensor_fault(&twin.get(), s) != TT_SENSOR_FINE)
        text += fmt::format(" {}={}", model.sensor_names[s], tt_twin_sensor_fault_text(&twin.get(), s));
    }
    text += "\n";
  }
  return text;
}

class ControlSource : public ::testing::Test {
protected:
  static constexpr int rows = 2000;

  ControlSource() {
    write_control_source(folder_.path() / "c", control_.data(), control_.model());
    folder_.write("rows.csv", csv(rows));
  }
  std::string compiled(const std::string& compiler) const {
    const std::string program = (folder_.path() / "twin").string();
    const Said said =
        run(fmt::format("cd {} && {} -std=c99 -Wall -Wextra -Werror -pedantic -ffp-contract=off *.c -o {} -lm",
                        (folder_.path() / "c").string(), compiler, program));
    EXPECT_EQ(said.status, 0) << compiler << ": " << said.text;
    return program;
  }
  /// A header alone, as standard input.
  std::string no_rows() const {
    folder_.write("no_rows.csv", "time_s\n");
    return " < " + (folder_.path() / "no_rows.csv").string();
  }
  std::string run_on_rows(const std::string& program, const std::string& more = "") const {
    const Said said = run(fmt::format("{} --bits {} < {}", program, more, (folder_.path() / "rows.csv").string()));
    EXPECT_EQ(said.status, 0) << said.text;
    return said.text;
  }

  ControlModel control_{lumps()};
  test::Scratch folder_;
};

TEST_F(ControlSource, HasTheBitsOfTheCoreWithGcc) {
  const std::string truth = expected(control_.model(), rows);
  ASSERT_GT(std::count(truth.begin(), truth.end(), '\n'), rows);
  ASSERT_NE(truth.find("sensor_failed"), std::string::npos);
  EXPECT_TRUE(run_on_rows(compiled("gcc -O3")) == truth);
}

/// @return why the test is skipped; empty: all programs are there. With THERMOTWIN_COMPILERS=1, for which tools/test
///   installs them, a missing one is a failure.
std::string absent(std::initializer_list<const char*> programs) {
  for (const char* program : programs) {
    if (has_program(program)) continue;
    EXPECT_EQ(std::getenv("THERMOTWIN_COMPILERS"), nullptr) << "no " << program;
    return std::string("no ") + program;
  }
  return {};
}

TEST_F(ControlSource, HasTheBitsOfTheCoreWithClang) {
  if (const std::string none = absent({"clang"}); !none.empty()) GTEST_SKIP() << none;
  EXPECT_TRUE(run_on_rows(compiled("clang -O2")) == expected(control_.model(), rows));
}

TEST_F(ControlSource, HasTheBitsOfTheCoreOnAarch64) {
  if (const std::string none = absent({"aarch64-linux-gnu-gcc", "qemu-aarch64"}); !none.empty()) GTEST_SKIP() << none;
  const std::string arm = compiled("aarch64-linux-gnu-gcc -O3 -static");
  EXPECT_TRUE(run_on_rows("qemu-aarch64 " + arm) == expected(control_.model(), rows));
}

/// Rows of a shift with a failed sensor, a state that is written and read, and damaged ones.
TEST_F(ControlSource, HasNoFindingUnderAddressAndUndefinedSanitizers) {
  const std::string program =
      compiled("gcc -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer");
  const std::string state = (folder_.path() / "state").string();
  EXPECT_TRUE(run_on_rows(program, "--state " + state) == expected(control_.model(), rows));
  const std::string whole = core::read_file(state);
  for (const std::size_t length : {std::size_t{0}, std::size_t{7}, whole.size() / 2, whole.size() - 1}) {
    folder_.write("bad", whole.substr(0, length));
    const Said said =
        run(program + " --state " + (folder_.path() / "bad").string() + " < " + (folder_.path() / "rows.csv").string());
    EXPECT_NE(said.status, 0) << length;
    EXPECT_EQ(said.text.find("Sanitizer"), std::string::npos) << said.text;
    EXPECT_EQ(said.text.find("runtime error"), std::string::npos) << said.text;
  }
}

TEST_F(ControlSource, TheExampleGoesOnFromItsStateAndNeedsLibmAlone) {
  const std::string program = compiled("gcc -O0"), state = (folder_.path() / "state").string();
  const std::string whole = run_on_rows(program, "--state " + state);
  EXPECT_TRUE(whole == expected(control_.model(), rows)) << "gcc -O0";
  std::istringstream libraries(run("readelf -d " + program + " | grep NEEDED").text);
  for (std::string line; std::getline(libraries, line);) {
    const bool known = line.find("[libm.so") != std::string::npos || line.find("[libc.so") != std::string::npos;
    EXPECT_TRUE(known) << line;
  }
  const std::string after = core::read_file(state);
  std::filesystem::remove(state);
  std::istringstream lines(csv(rows));
  std::string header, first, second;
  std::getline(lines, header);
  int at = 0;
  for (std::string line; std::getline(lines, line); ++at) (at < 777 ? first : second) += line + "\n";
  std::string joined;
  for (const std::string& part : {first, second}) {
    folder_.write("rows.csv", header + "\n" + part);
    const std::string said = run_on_rows(program, "--state " + state);
    joined += joined.empty() ? said : said.substr(said.find('\n') + 1);
  }
  EXPECT_TRUE(joined == whole);
  EXPECT_TRUE(core::read_file(state) == after);
  folder_.write("bad", std::string(after).replace(100, 1, "#"));
  EXPECT_NE(
      run(program + " --state " + (folder_.path() / "bad").string() + " < " + (folder_.path() / "rows.csv").string())
          .status,
      0);
}

TEST_F(ControlSource, TheExampleNamesWhatDoesNotFitAndGoesOn) {
  const std::string program = compiled("gcc -O1");
  const auto said = [&](const std::string& text) {
    folder_.write("odd.csv", text);
    return run(program + " < " + (folder_.path() / "odd.csv").string());
  };
  for (const std::string& text :
       {std::string(), std::string("air.T_C\n20\n"), std::string("time_s,air.T_C,air.T_C\n")}) {
    const Said refused = said(text);
    EXPECT_EQ(WEXITSTATUS(refused.status), 3) << text;
    EXPECT_NE(refused.text.find("stdin:1: "), std::string::npos) << refused.text;
  }
  const Said odd = said("# machine of rows 0\ntime_s,air.T_C\n0,20\n60,20,7\n120,2O\n,20\n240,20\n");
  EXPECT_EQ(odd.status, 0);
  EXPECT_NE(odd.text.find("stdin:4: another number of cells"), std::string::npos) << odd.text;
  EXPECT_NE(odd.text.find("stdin:5: 2O; allowed: a number"), std::string::npos) << odd.text;
  std::istringstream lines(odd.text);
  int rows_said = 0, missing = 0;
  for (std::string line; std::getline(lines, line);) {
    rows_said += line.starts_with("0,") || line.starts_with("120,") || line.starts_with("240,");
    missing += line.ends_with(",input_missing") && (line.starts_with("0,") || line.starts_with("120,"));
  }
  EXPECT_EQ(rows_said, 5);  // the two rows that do not fit have the time of the row before
  EXPECT_GE(missing, 2);
}

/// A write may end after any byte, or leave the version before; the program may be killed between rows.
TEST_F(ControlSource, TheStateIsWrittenWholeAndADamagedOneIsRefusedByName) {
  const std::string program = compiled("gcc -O1"), state = (folder_.path() / "state").string();
  const std::string all = csv(rows);
  // Killed amid its rows, with 40 kB of them: what it left is a state of some minute before.
  const std::string cut = all.substr(0, 40000);
  folder_.write("part.csv", cut.substr(0, cut.rfind('\n') + 1));
  const std::string part = (folder_.path() / "part.csv").string();
  const std::string pipe = (folder_.path() / "pipe").string();
  const Said killed = run(
      fmt::format("mkfifo {0}; (cat {1}; exec sleep 20) > {0} & feeds=$!; {2} --state {3} < {0} > /dev/null & runs=$!; "
                  "n=0; while [ ! -f {3} ] && [ $n -lt 250 ]; do sleep 0.02; n=$((n + 1)); done; "
                  "kill -9 $runs; kill $feeds",
                  pipe, part, program, state));
  ASSERT_TRUE(std::filesystem::exists(state)) << killed.text;
  EXPECT_EQ(run(program + " --state " + state + no_rows()).status, 0) << "the killed program's";
  run_on_rows(program, "--state " + state + "1");
  const std::string whole = core::read_file(state + "1");
  EXPECT_FALSE(std::filesystem::exists(state + "1.new"));
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, std::size_t{39}, std::size_t{40}, std::size_t{41},
                                  whole.size() / 2, whole.size() - 1}) {
    core::write_file(state + "1.new", whole.substr(0, bytes));
    core::write_file(state + "1", whole);
    EXPECT_EQ(run(program + " --state " + state + "1" + no_rows()).status, 0) << "beside a part of a new one";
    core::write_file(state + "2", whole.substr(0, bytes));
    const Said said = run(program + " --state " + state + "2" + no_rows());
    EXPECT_EQ(WEXITSTATUS(said.status), 3) << bytes;
    EXPECT_NE(said.text.find(bytes < 40 ? "no state" : "a damaged state"), std::string::npos) << said.text;
    EXPECT_EQ(core::read_file(state + "2").size(), bytes) << "left as it was";
  }
  ControlOptions options;
  options.compensator.step_s = 30.0;
  const ControlModel another(lumps(), options);
  const std::vector<unsigned char> other = test::Twin(another.model()).saved();
  core::write_file(state + "3", std::string(other.begin(), other.end()));
  EXPECT_NE(run(program + " --state " + state + "3" + no_rows()).text.find("another model"), std::string::npos);
}

TEST(ControlLibrary, NeedsNothingButLibmAndLibc) {
  // bcmp is what clang makes of a memcmp of which only 0 counts.
  const std::set<std::string> allowed = {"memcpy", "memset", "memcmp", "bcmp", "strlen",
                                         "sqrt",   "fabs",   "floor",  "ceil"};
  const Said said = run("nm -P " THERMOTWIN_CONTROL_LIBRARY);
  ASSERT_EQ(said.status, 0) << said.text;
  std::set<std::string> defined, needed;
  std::istringstream lines(said.text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, kind;
    words >> name >> kind;
    const bool of_sanitizer =
        name.starts_with("__asan_") || name.starts_with("__ubsan_") || name.starts_with("__tsan_");
    if (kind == "U" && !of_sanitizer) needed.insert(name);
    if (kind == "T") defined.insert(name);
  }
  EXPECT_GT(defined.size(), 40U);
  for (const std::string& name : needed) EXPECT_TRUE(defined.count(name) + allowed.count(name) > 0) << name;
  for (const std::string& name : defined) EXPECT_TRUE(name.starts_with("tt_")) << name;
}

// A name is any text of machine.toml; it is neither source nor the end of a comment.
TEST(ControlText, ANameThatLooksLikeSourceIsNone) {
  ControlData data = control_data(lumps());
  data.name = "5\" mill \\ */ #error ?\?/ /* \xC3\xA4\nint x;";
  data.channel_names.at(0) = "a-b";
  data.channel_names.at(1) = "a_b";
  const ControlModel model(data);
  const test::Scratch folder;
  write_control_source(folder.path(), data, model.model());
  const std::string place = folder.path().string();
  ASSERT_EQ(run("cd " + place + " && gcc -std=c99 -Wall -Wextra -Werror -pedantic -c model_data.c").text, "");
  core::write_file(
      folder.path() / "name.c",
      "#include <stdio.h>\n#include \"model_data.h\"\nint main(void) { return puts(tt_the_model.name) < 0; }\n");
  const Said said = run("cd " + place + " && gcc -std=c99 name.c model_data.o -o name -lm && ./name");
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(said.text, data.name + "\n");
  for (const char* file : {"model_data.c", "model_data.h"})
    EXPECT_EQ(core::read_file(folder.path() / file).find("\nint x;"), std::string::npos) << file;
  EXPECT_EQ(comment_text("a*\\ b\n/**/"), "a*| b / * * /");
}

}  // namespace
}  // namespace thermotwin::compensation
