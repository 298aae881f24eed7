// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A client of `serve --socket`.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <iterator>
#include <string>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>

namespace thermotwin::cases {

inline void wait_s(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

class Socket {
public:
  explicit Socket(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::snprintf(address.sun_path, sizeof address.sun_path, "%s", path.c_str());
    descriptor_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    for (int i = 0; i < 500; ++i) {
      if (::connect(descriptor_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return;
      wait_s(0.02);
    }
    ADD_FAILURE() << path << " is not served";
  }
  ~Socket() { ::close(descriptor_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  /// @return whether somebody has taken it
  bool send(const std::string& text) const {
    return ::send(descriptor_, text.data(), text.size(), MSG_NOSIGNAL) == std::ssize(text);
  }
  /// Without its end; empty: the connection is closed.
  std::string line() const {
    std::string line;
    char c = 0;
    while (::recv(descriptor_, &c, 1, 0) == 1 && c != '\n') line += c;
    return line;
  }

private:
  int descriptor_ = -1;
};

}  // namespace thermotwin::cases
