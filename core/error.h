// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The exceptions of the program. The command line turns each into an exit status: wrong usage 2, bad input 3, failed
// numerics 4, interrupted 130. A message names the place, the value found there and what is allowed.

#include <stdexcept>
#include <string>

namespace thermotwin::core {

class Error : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
  virtual int exit_status() const noexcept { return 4; }
};

/// The command line was used wrongly.
class UsageError : public Error {
public:
  using Error::Error;
  int exit_status() const noexcept override { return 2; }
};

/// A file, a table or a value that a user gave cannot be used.
class InputError : public Error {
public:
  using Error::Error;
  /// @param place    file with line or column, e.g. "machine.toml:12 body.material"
  /// @param value    what was found there, as written
  /// @param allowed  what would be right, as a phrase: "one of: cast_iron, steel"
  InputError(const std::string& place, const std::string& value, const std::string& allowed);
  int exit_status() const noexcept override { return 3; }
};

/// A geometry or mesh cannot be used. The message names the body and the element.
class MeshError : public InputError {
public:
  using InputError::InputError;
};

/// The numerics failed: a factorisation, an iteration or the memory.
class SolverError : public Error {
public:
  using Error::Error;
};

/// The user asked to stop (Ctrl-C).
class Interrupted : public Error {
public:
  Interrupted() : Error("interrupted; completed results are kept") {}
  int exit_status() const noexcept override { return 130; }
};

}  // namespace thermotwin::core
