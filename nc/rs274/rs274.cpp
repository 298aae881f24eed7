// SPDX-License-Identifier: GPL-2.0-or-later
// The helper process: reads a job from standard input, runs the program through LinuxCNC's interpreter and writes
// records to standard output. A job is lines of
//   program PATH | folder PATH | moves N | idle_blocks N | seconds N | axes MASK | start x y z a b c u v w
//   work NUMBER x y z a b c u v w rotation    (work offset 1 to 9, mm and deg)
//   tool NUMBER x y z a b c u v w diameter front back orientation
//   rule ACTION LETTER NUMBER SECOND TEXT     (SECOND - for none, TEXT to the end of the line)
//   fanuc 1 | block_delete 0 | open_end 0     (a program may end without M2, M30 or %)
#include <canon.hh>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <interp_base.hh>
#include <interp_return.hh>
#include <iostream>
#include <new>
#include <sstream>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

#include "nc/rs274/canon.h"
#include "nc/rs274/files.h"
#include "nc/rs274/stream.h"
#include "nc/rs274/tools.h"

// The library takes these from its host. No Python module is built in, and without the plugin no comment runs Python.
struct NoModule {
  const char* name;
  void* start;
};
extern "C" {
NoModule builtin_modules[] = {{nullptr, nullptr}};
int _task = 0;
// No pins of a running control are read.
int hal_init(const char* /*name*/) { return -1; }
int hal_ready(int /*id*/) { return -1; }
}
class PythonPlugin;
extern PythonPlugin* python_plugin;

namespace {

using namespace thermotwin::nc::rs274;

struct Job {
  std::string program, folder;
  Limits limits;
  rlim_t seconds = 60;
  std::vector<Rule> rules;
  bool fanuc = false, open_end = true;
  std::vector<std::string> before;  ///< lines that set the work offsets
};

Rule::Action action_of(const std::string& word) {
  if (word == "skip") return Rule::Action::skip;
  if (word == "replace") return Rule::Action::replace;
  return Rule::Action::refuse;
}

Job read_job() {
  Job job;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream in(line);
    std::string key;
    in >> key >> std::ws;
    if (key == "program") std::getline(in, job.program);
    if (key == "folder") std::getline(in, job.folder);
    if (key == "moves") in >> job.limits.moves;
    if (key == "idle_blocks") in >> job.limits.idle_blocks;
    if (key == "seconds") in >> job.seconds;
    if (key == "fanuc") in >> job.fanuc;
    if (key == "open_end") in >> job.open_end;
    if (key == "block_delete") {
      bool on = true;
      in >> on;
      set_block_delete(on);
    }
    if (key == "axes") {
      int mask = 0;
      in >> mask;
      set_axis_mask(mask);
    }
    if (key == "start") {
      double position[9] = {};
      for (double& value : position) in >> value;
      start_at(position);
    }
    if (key == "tool") {
      CANON_TOOL_TABLE tool{};
      EmcPose& o = tool.offset;
      in >> tool.toolno >> o.tran.x >> o.tran.y >> o.tran.z >> o.a >> o.b >> o.c >> o.u >> o.v >> o.w >>
          tool.diameter >> tool.frontangle >> tool.backangle >> tool.orientation;
      tool.pocketno = tool_table().size();
      add_tool(tool);
    }
    if (key == "work") {
      int number = 0;
      in >> number;
      std::string text = "G10 L2 P" + std::to_string(number);
      for (const char letter : std::string("XYZABCUVWR")) {
        double value = 0.0;
        in >> value;
        // Programs know no exponents.
        char word[64];
        std::snprintf(word, sizeof word, " %c%.9f", letter, value);
        if (value != 0.0) text += word;
      }
      job.before.push_back(text);
    }
    if (key == "rule") {
      Rule rule{};
      std::string action, second;
      in >> action >> rule.letter >> rule.number >> second >> std::ws;
      std::getline(in, rule.text);
      rule.action = action_of(action);
      if (second != "-") rule.second = second;
      job.rules.push_back(rule);
    }
  }
  return job;
}

void limit(int what, rlim_t most) {
  const rlimit both{most, what == RLIMIT_CPU ? most + 2 : most};
  setrlimit(what, &both);
}

extern "C" void out_of_time(int) { stop(Stop::time, ""); }

[[noreturn]] void refuse(InterpBase& interpreter, int status) {
  char text[512] = {}, file[512] = {};
  interpreter.error_text(status, text, sizeof text);
  interpreter.file(file, sizeof file);
  if (!refused_file().empty()) stop(Stop::file, refused_file());
  stop(Stop::program, text[0] != 0 ? text : "the interpreter stopped without a message");
}

/// The file has ended without M2, M30 or %.
bool is_open_end(InterpBase& interpreter, int status) {
  char text[512] = {};
  interpreter.error_text(status, text, sizeof text);
  return std::strstr(text, "ended with no percent sign") != nullptr;
}

/// Whether the file may end behind the line that was executed last: outside of subprograms and of skipped lines.
bool may_end_behind(InterpBase& interpreter, bool before, bool ran) {
  char text[512] = {};
  interpreter.line_text(text, sizeof text);
  const std::string line = text;
  const std::size_t first = line.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return before;
  if (interpreter.call_level() > 0) return false;
  if (line[first] != 'o' && line[first] != 'O') return ran;
  // The end of a subprogram, a branch or a loop; others of these lines end nothing.
  return before || line.find("end") != std::string::npos || line.find("END") != std::string::npos;
}

void name_file(InterpBase& interpreter, std::string& last) {
  char name[512] = {};
  interpreter.file(name, sizeof name);
  if (last == name || name[0] == 0) return;
  last = name;
  write_text(Kind::file, 0, 0, last);
}

void run(InterpBase& interpreter, const Job& job) {
  if (const int status = interpreter.init(); status > INTERP_MIN_ERROR) refuse(interpreter, status);
  interpreter.set_loop_on_main_m99(false);
  for (const std::string& line : job.before)
    if (const int status = interpreter.execute(line.c_str()); status > INTERP_MIN_ERROR) refuse(interpreter, status);
  if (const int status = interpreter.open(job.program.c_str()); status > INTERP_MIN_ERROR) {
    if (!refused_file().empty()) stop(Stop::file, refused_file());
    stop(Stop::file, job.program);
  }
  std::string file;
  bool may_end = true;  // not within a subprogram, nor where lines are skipped
  for (;;) {
    const int read = interpreter.read();
    name_file(interpreter, file);
    begin_block(interpreter.sequence_number(), interpreter.call_level());
    if (read == INTERP_ENDFILE) break;
    if (read > INTERP_MIN_ERROR && job.open_end && may_end && is_open_end(interpreter, read)) {
      write_setting(Setting::open_end, 1);
      break;
    }
    if (read > INTERP_MIN_ERROR) refuse(interpreter, read);
    const int depth = interpreter.call_level();
    const int done = interpreter.execute();
    if (done > INTERP_MIN_ERROR) refuse(interpreter, done);
    if (done == INTERP_EXIT) {
      write_values(Kind::end, static_cast<std::uint8_t>(depth), current_line(), nullptr, 0);
      return;
    }
    may_end = may_end_behind(interpreter, may_end, has_run() || done == INTERP_EXECUTE_FINISH);
    // M6 and M66 end a line before the interpreter tells that it ran.
    if (!has_run() && done != INTERP_EXECUTE_FINISH) write_setting(Setting::skipped, 1);
    if (done == INTERP_EXECUTE_FINISH) interpreter.synch();
  }
  write_values(Kind::end, static_cast<std::uint8_t>(interpreter.call_level()), current_line(), nullptr, 0);
}

}  // namespace

int main() {
  const Job job = read_job();
  take_standard_output();
  InterpBase* interpreter = makeInterp();
  python_plugin = nullptr;
  set_limits(job.limits);
  std::signal(SIGXCPU, out_of_time);
  std::signal(SIGXFSZ, SIG_IGN);
  limit(RLIMIT_CPU, job.seconds);
  limit(RLIMIT_FSIZE, 0);
  limit(RLIMIT_CORE, 0);
  try {
    guard_files(job.folder, job.rules, job.fanuc);
    run(*interpreter, job);
  } catch (const std::bad_alloc&) {
    stop(Stop::internal, "out of memory");
  } catch (const std::exception& error) {
    stop(Stop::internal, error.what());
  } catch (...) {
    stop(Stop::internal, "an exception of Python");
  }
  flush();
  _exit(0);
}
