// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The built program as a child process: arguments in, exit status and both outputs out.

#include <cstdint>
#include <string>
#include <sys/types.h>
#include <vector>

namespace thermotwin::cases {

struct Result {
  int status = 0;        ///< exit status; -n if signal n ended it
  std::string out, err;  ///< standard output and standard error
};

struct Surroundings {
  std::uint64_t largest_file = 0;  ///< bytes that a file may have (0: no limit); beyond it a write
                                   ///< fails as on a full disk
  std::uint64_t memory = 0;        ///< bytes of address space (0: no limit)
  std::string output;              ///< file that takes standard output, e.g. /dev/full
  bool display = false;            ///< keeps DISPLAY; else no picture is drawn
  std::string folder;              ///< that it is started in; empty: that of the test
};

/// Killed after two minutes, which no test needs.
class Program {
public:
  explicit Program(const std::vector<std::string>& arguments, const Surroundings& surroundings = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void write(const std::string& text);  ///< to its standard input
  void close_input();
  std::string read_line();  ///< next line of its standard output, without the end; waits
  void send(int signal);
  bool is_running();  ///< also keeps its outputs from filling up
  bool ends_within(double seconds);
  Result wait();  ///< closes the input, reads on to the end

private:
  void pump(int milliseconds);
  void reap(bool block);

  pid_t child_ = -1;
  int in_ = -1, out_ = -1, err_ = -1;
  std::int64_t deadline_ms_ = 0;
  bool ended_ = false;
  Result result_;
  std::size_t taken_ = 0;  ///< of result_.out by read_line
};

/// Runs the program to its end.
Result thermotwin(const std::vector<std::string>& arguments, const std::string& input = "",
                  const Surroundings& surroundings = {});

}  // namespace thermotwin::cases
