// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One run of a program from outside: wall and processor time, peak memory by the kernel's account, and
// the numbers that it prints as lines "name value".

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace thermotwin::bench {

struct Command {
  std::vector<std::string> words;        ///< program (looked up in PATH) and arguments
  int cores = 0;                         ///< > 0: may use this many processors only
  std::vector<std::string> environment;  ///< "NAME=value", on top of the present one
  std::filesystem::path folder;          ///< to run in; empty: the present one
  std::filesystem::path input, output;   ///< files for stdin and stdout; empty: none, kept
};

struct Outcome {
  double seconds = 0, processor_seconds = 0, peak_MiB = 0;
  std::map<std::string, double> values;
  /// @throws SolverError if the program did not print the name
  double operator[](const std::string& name) const;
};

/// @throws SolverError with the end of what the program said, if it fails
Outcome run(const Command& command);

bool have_program(const std::string& name);

}  // namespace thermotwin::bench
