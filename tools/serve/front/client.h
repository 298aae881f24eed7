// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where rows come from and answers go: standard input and output, or a client of the local socket.

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace thermotwin::tools {

/// A longer line is no row. The sender of one without an end is not heard any more.
inline constexpr std::size_t longest_row = (1U << 18U) - 2U, longest_skipped = 1U << 24U;

class Client {
public:
  /// @param is_socket  in and out are the same descriptor, which this object closes
  Client(int in, int out, bool is_socket) : in_(in), out_(out), is_socket_(is_socket) {}
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  int descriptor() const { return in_; }
  bool is_socket() const { return is_socket_; }
  /// No further line will come.
  bool ended() const { return ended_ && text_.find('\n', at_) == std::string::npos; }
  /// Its input has ended; lines may still wait.
  bool input_ended() const { return ended_; }
  void end();

  /// Reads what has come; for a descriptor that is ready.
  void read();
  /// @return the next line with its end, the first characters of one that is too long; empty: none
  std::string line();
  /// What has come behind it.
  std::string_view waiting() const { return std::string_view(text_).substr(std::min(at_, text_.size())); }
  /// A client of the socket that does not take its answers is not waited for. A reader of standard output is.
  void write(const std::string& text);

private:
  /// Of a line that is too long, what follows its first characters is left out as it comes.
  void take(std::string_view fresh);
  bool write_whole(const std::string& text) const;

  int in_, out_;
  bool is_socket_, ended_ = false;
  std::string text_;
  std::size_t at_ = 0;       ///< begin of the next line
  std::size_t skipped_ = 0;  ///< characters of the last line, which is too long
};

/// A listening local socket; one that a killed process left is replaced.
class Listener {
public:
  /// @throws InputError for a path that is too long, in use or cannot be written
  explicit Listener(const std::filesystem::path& path);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  int descriptor() const { return descriptor_; }

private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace thermotwin::tools
