// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/program/interpreter.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <optional>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "core/character.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/signals.h"
#include "core/units.h"
#include "nc/dialect/tcp_marker.h"
#include "nc/dialect/translated_program.h"

namespace thermotwin::nc {

using core::InputError;
using rs274::Kind;
using rs274::Stop;
namespace units = core::units;

namespace {

/// A value for the helper: mm or deg.
double outside(double value, int letter) { return value / (is_angle(letter) ? units::deg : units::mm); }

std::string nine_text(const Nine& values) {
  std::string text;
  for (int i = 0; i < 9; ++i) text += fmt::format(" {:.12g}", outside(values[i], i));
  return text;
}

std::string rule_text(const WordRule& rule) {
  const std::string head = fmt::format(" {} {} {} ", rule.letter, rule.number, rule.with.empty() ? "-" : rule.with);
  switch (rule.action) {
    case WordRule::Action::skip: return "rule skip" + head;
    case WordRule::Action::replace: return "rule replace" + head + rule.by;
    case WordRule::Action::tcp_on: return "rule replace" + head + rule.by + marker_comment(tcp_on_marker);
    case WordRule::Action::tcp_off: return "rule replace" + head + rule.by + marker_comment(tcp_off_marker);
    default: return "rule refuse" + head + rule.says;
  }
}

std::string job_text(const InterpreterOptions& options, const ControlProfile& control,
                     const std::filesystem::path& program, const std::filesystem::path& folder) {
  std::string job = fmt::format("program {}\nfolder {}\nmoves {:.0f}\nidle_blocks {:.0f}\nseconds {:.0f}\naxes {}\n",
                                program.string(), folder.string(), control.moves, control.lines_without_move,
                                control.seconds, options.axis_mask);
  job += fmt::format("fanuc {:d}\nblock_delete {:d}\nopen_end {:d}\n", control.dialect == Dialect::fanuc,
                     control.block_delete, options.open_end);
  job += "start" + nine_text(options.start) + "\n";
  for (const WorkOffset& offset : control.work_offsets)
    job += fmt::format("work {}{} {:.12g}\n", offset.number, nine_text(offset.offset), offset.rotation / units::deg);
  for (const Tool& tool : control.tools)
    job += fmt::format("tool {}{} {:.12g} {:.12g} {:.12g} {}\n", tool.number, nine_text(tool.offset),
                       tool.diameter / units::mm, tool.front_angle, tool.back_angle, tool.orientation);
  for (const WordRule& rule : control.words)
    if (rule.name.empty()) job += rule_text(rule) + "\n";
  return job;
}

/// The helper as a child with its job on standard input.
class Child {
public:
  Child(const std::filesystem::path& helper, const std::filesystem::path& folder, const std::string& job) {
    // The job fits no pipe where there are many tools, so it waits in a file without a name.
    const int in = memfd_create("thermotwin_nc_job", MFD_CLOEXEC);
    int ends[2];
    if (in < 0 || pipe2(ends, O_CLOEXEC) != 0) throw core::SolverError("nc: no pipe to the interpreter");
    std::size_t at = 0;
    while (at < job.size()) {
      const ssize_t n = write(in, job.data() + at, job.size() - at);
      if (n <= 0) throw core::SolverError("nc: no room for the interpreter's job");
      at += n;
    }
    lseek(in, 0, SEEK_SET);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    std::string path = helper.string(), python = "PYTHONNOUSERSITE=1", safe = "PYTHONSAFEPATH=1", locale = "LC_ALL=C",
                bytecode = "PYTHONDONTWRITEBYTECODE=1";
    char* arguments[] = {path.data(), nullptr};
    char* environment[] = {python.data(), safe.data(), locale.data(), bytecode.data(), nullptr};
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    core::open_ending_signals(attributes);
    const int failed = posix_spawn(&pid_, path.c_str(), &actions, &attributes, arguments, environment);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    close(in);
    close(ends[1]);
    out_ = ends[0];
    if (failed != 0) {
      close(out_);
      throw core::SolverError(fmt::format("nc: {} does not start: {}", path, std::strerror(failed)));
    }
  }
  ~Child() {
    close(out_);
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      int status = 0;
      waitpid(pid_, &status, 0);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int output() const { return out_; }
  /// @return wait status
  int wait() {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {}
    pid_ = -1;
    return status;
  }

private:
  pid_t pid_ = -1;
  int out_ = -1;
};

/// Takes records out of the bytes that have come.
class Decoder {
public:
  explicit Decoder(const std::function<void(const Record&)>& take) : take_(take) {}

  /// @return bytes used
  std::size_t take(const char* data, std::size_t size) {
    std::size_t at = 0;
    while (size - at >= sizeof(rs274::Head)) {
      rs274::Head head;
      std::memcpy(&head, data + at, sizeof head);
      const bool text = head.kind == Kind::file || head.kind == Kind::marker || head.kind == Kind::error;
      const std::size_t body = text ? head.mask : sizeof(double) * static_cast<std::size_t>(std::popcount(head.mask));
      if (head.kind < Kind::block || head.kind > Kind::end)
        throw core::SolverError("nc: the interpreter's stream is broken");
      if (size - at < sizeof head + body) break;
      const char* from = data + at + sizeof head;
      Record record{head.kind, head.index, head.line, {}, {}};
      if (text) {
        record.text = std::string_view(from, body);
      } else {
        auto& values = last_[static_cast<std::size_t>(head.kind)];
        for (std::size_t i = 0; i < values.size(); ++i) {
          if ((head.mask >> i & 1U) == 0) continue;
          std::memcpy(&values[i], from, sizeof(double));
          from += sizeof(double);
        }
        record.values = values;
      }
      take_(record);
      at += sizeof head + body;
    }
    return at;
  }

private:
  const std::function<void(const Record&)>& take_;
  std::array<std::array<double, 16>, 13> last_{};
};

/// A program is text: it has neither control characters nor lines that the interpreter cuts.
struct LineCount {
  long all = 0, deletable = 0;  ///< deletable: they begin with /
};

LineCount require_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path.string(), "cannot be read", "an NC program");
  std::vector<char> part(1U << 16U);
  std::size_t line = 1, length = 0;
  long deletable = 0;
  bool blank = true, begins = true;
  constexpr std::size_t longest = 254;
  while (in.read(part.data(), std::ssize(part)), in.gcount() > 0) {
    for (const char letter : std::string_view(part.data(), in.gcount())) {
      const unsigned char c = core::byte_of(letter);
      constexpr unsigned char end_of_text = 26;  // the last byte of programs from old systems
      if (c < 32 && c != '\t' && c != '\n' && c != '\r' && c != end_of_text)
        throw InputError(fmt::format("{}:{}", path.string(), line), fmt::format("a byte of value {}", c),
                         "text: an NC program has no control characters");
      if (begins && c == '/') ++deletable;
      begins = c == '\n' || (begins && c <= ' ');
      length = c == '\n' ? 0 : length + 1;
      blank = blank && (c <= ' ' || c == end_of_text);
      if (length > longest)
        throw InputError(fmt::format("{}:{}", path.string(), line),
                         fmt::format("a line of more than {} characters", longest), "shorter lines");
      if (c == '\n') ++line;
    }
  }
  if (blank) throw InputError(path.string(), "an empty file", "an NC program, which ends with M2, M30 or %");
  return {std::lround(1.0 * line), deletable};
}

/// What is allowed where the interpreter refuses a line, by its words.
std::string allowed_for(const std::string& says, const ControlProfile& control) {
  static constexpr std::pair<const char*, const char*> remedies[] = {
      {"not found in the tool table", "tools as [[tool]] of the control profile (--control) or as a table (--tools)"},
      {"Python", "comments without Python, which is never run"},
      {"zero feed rate", "a feed rate F above 0 in this line or before it"},
      {"F word missing", "F in each line of inverse time (G93) that moves at feed"},
      {"Radius to end of arc", "a centre (I, J, K) that is equally far from the arc's start and end"},
      {"radius too small", "an arc radius R of at least half of the distance from its start to its end"},
      {"same as end point of arc", "a whole circle with its centre I, J, K; R needs two points"},
      {"i j k words all missing", "arcs with a radius R or with a centre I, J, K"},
      {"R clearance plane", "R, the height to which a cycle retracts, in its first line"},
      {"Q word missing", "Q, the depth of a peck, in the first line of the cycle"},
      {"Dwell time missing", "P, the dwell in s, in the line of G4"},
      {"Multiple", "each letter once in a line, but for G and M"},
      {"same modal group", "one G or M word of each modal group in a line"},
      {"divide by zero", "a divisor other than 0"},
      {"no percent sign", "M2 or M30 as the last line that runs, or % in the first and last line"},
      {"seeking o-word", "subprograms in the program or in files of its folder (--folder): o1001.ngc for O1001"},
      {"spline", "lines and arcs: G0, G1, G2, G3"},
      {"Failed to find sub", "subprograms in the program or in files of its folder (--folder): o1001.ngc for O1001"},
      {"unary operation", "expressions in square brackets with +, -, *, /, MOD, SIN[...]; O-words for jumps and loops"},
      {"Unknown word starting with", "O-words for branches and loops (o1 if [#1 gt 2]), which this interpreter knows"},
      {"word with no", "words in a line with a G or M word that uses them"},
      {"Unknown g code", "G words of LinuxCNC; a [[word]] of the control profile skips or replaces another one"},
      {"Unknown m code", "M words of LinuxCNC; a [[word]] of the control profile skips or replaces another one"},
      {"Bad character '+'", "expressions in square brackets: X[#1+2]"},
      {"Bad character '*'", "expressions in square brackets: X[#1*2]"},
      {"Bad character '%'", "% in the first and last line"},
      {"Bad character", "words with the letters of this machine's axes, comments in brackets, one block in a line"},
      {"two g codes that both use axis values", "one of them in a line"},
      {"Nested comment", "comments without brackets inside"},
      {"Unclosed comment", "comments that end with ')' in their line"},
      {"Parameter number out of range", "parameters #1 to #5602"},
      {"Named parameter", "named parameters that the program sets before"}};
  for (const auto& [words, allowed] : remedies)
    if (says.find(words) != std::string::npos) return allowed;
  return "the words that LinuxCNC's interpreter and the control profile '" + control.name + "' know";
}

/// A loop without an end is found soon where the program is short.
ControlProfile limited(ControlProfile control, long lines) {
  constexpr double of_a_line = 100, least = 1e6;
  if (!control.moves_stated) control.moves = std::min(control.moves, std::max(least, of_a_line * lines));
  return control;
}

[[noreturn]] void refuse(const Record& error, const std::string& file, const std::filesystem::path& folder,
                         const ControlProfile& control) {
  const std::string place = fmt::format("{}:{}", file, std::max<std::uint32_t>(error.line, 1));
  const std::string text(error.text);
  switch (static_cast<Stop>(error.index)) {
    case Stop::program: {
      // The reason, and behind a tab what is allowed.
      const std::size_t tab = text.find('\t');
      if (tab != std::string::npos) throw InputError(place, text.substr(0, tab), text.substr(tab + 1));
      throw InputError(place, text, allowed_for(text, control));
    }
    case Stop::file:
      throw InputError(place, "the file " + text + " is outside of the folder, or cannot be read",
                       "programs and subprograms below " + folder.string());
    case Stop::moves:
      throw InputError(place, fmt::format("more than {:.0f} moves: does it end?", control.moves),
                       "a program that ends, or more limits.moves in the control profile");
    case Stop::idle_blocks:
      throw InputError(place,
                       fmt::format("more than {:.0f} lines without a move: does it end?", control.lines_without_move),
                       "a program that ends, or more limits.lines_without_move in the control profile");
    case Stop::time:
      throw InputError(place, fmt::format("the interpreter took more than {:.0f} s: does it end?", control.seconds),
                       "a program that ends, or more limits.seconds in the control profile");
    default: throw InputError(place, "the interpreter failed: " + text, "a program that it can read");
  }
}

}  // namespace

std::filesystem::path find_helper() {
  std::error_code ignored;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const std::filesystem::path& folder : {here, here / THERMOTWIN_HELPERS, here.parent_path()}) {
    const std::filesystem::path path = folder / "thermotwin_rs274";
    if (access(path.c_str(), X_OK) == 0) return path;
  }
  return {};
}

namespace {

/// A file as the user's folder sees it: the interpreter works in the folder of the program.
/// @param program  as the interpreter has it
std::string name_of(std::string_view file, const std::filesystem::path& program, const InterpreterOptions& options) {
  if (file == program.string()) return options.program.string();
  if (!std::filesystem::path(file).is_relative()) return std::string(file);
  return ((options.folder.empty() ? options.program.parent_path() : options.folder) / file).string();
}

}  // namespace

long interpret(const InterpreterOptions& options, const ControlProfile& given,
               const std::function<void(const Record&)>& take) {
  const std::filesystem::path helper = options.helper.empty() ? find_helper() : options.helper;
  if (helper.empty())
    throw core::UsageError(
        "nc: LinuxCNC's interpreter (thermotwin_rs274) is not beside this program; install the package thermotwin-nc, "
        "or build where linuxcnc-uspace and linuxcnc-uspace-dev are installed, and install the component nc");
  const LineCount lines = require_text(options.program);
  const ControlProfile control = limited(given, lines.all);
  std::optional<TranslatedProgram> translated;
  if (control.dialect == Dialect::siemens)
    translated.emplace(options.program, control, options.axis_mask, options.start);
  const std::filesystem::path program = translated ? translated->path() : std::filesystem::canonical(options.program);
  if (!options.folder.empty() && !std::filesystem::is_directory(options.folder))
    throw InputError(options.folder.string(), "is no folder",
                     "a folder with the program and its subprograms (--folder)");
  const std::filesystem::path folder =
      translated || options.folder.empty() ? program.parent_path() : std::filesystem::canonical(options.folder);
  for (const std::string& path : {program.string(), folder.string()})
    if (path.find('\n') != std::string::npos) throw InputError(path, "a line end in a path", "a path without");
  Child child(helper, folder, job_text(options, control, program, folder));

  std::string file = options.program.string();
  std::uint32_t line = 0;
  bool ended = false;
  const std::function<void(const Record&)> look = [&](const Record& came) {
    Record record = came;
    if (record.kind == Kind::error) refuse(record, file, folder, control);
    if (record.kind == Kind::file) {
      file = name_of(record.text, program, options);
      record.text = file;
    }
    if (record.kind == Kind::block) line = record.line;
    if (record.kind == Kind::end) {
      ended = true;
      if (record.index > 0)
        throw InputError(fmt::format("{}:{}", file, line), "the program ends inside a subprogram",
                         "M2 or M30 in the main program, after all subprograms have returned");
    }
    take(record);
  };
  Decoder decoder(look);
  std::vector<char> bytes(1U << 18U);
  std::size_t held = 0;
  // Processor time ends the helper; a helper that sleeps is ended here.
  const auto patience = std::chrono::duration<double>(control.seconds + 30.0);
  auto heard = std::chrono::steady_clock::now();
  for (;;) {
    core::check_interrupt();
    pollfd waiting{child.output(), POLLIN, 0};
    if (poll(&waiting, 1, 200) <= 0) {
      if (std::chrono::steady_clock::now() - heard > patience)
        throw InputError(fmt::format("{}:{}", file, std::max<std::uint32_t>(line, 1)), "the interpreter hangs",
                         "a program that it can read");
      continue;
    }
    const ssize_t n = read(child.output(), bytes.data() + held, bytes.size() - held);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    heard = std::chrono::steady_clock::now();
    held += n;
    const std::size_t used = decoder.take(bytes.data(), held);
    std::memmove(bytes.data(), bytes.data() + used, held - used);
    held -= used;
  }
  const int status = child.wait();
  // Ctrl-C on a terminal ends the helper as well.
  core::check_interrupt();
  if (!ended)
    throw InputError(fmt::format("{}:{}", file, std::max<std::uint32_t>(line, 1)),
                     WIFSIGNALED(status) ? fmt::format("the interpreter was ended by signal {}", WTERMSIG(status))
                                         : "the interpreter ended before the program",
                     "a program that LinuxCNC's interpreter can read");
  return lines.deletable;
}

}  // namespace thermotwin::nc
