// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/client.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <sys/un.h>
#include <system_error>
#include <unistd.h>

#include "core/error.h"
#include "core/progress.h"

namespace thermotwin::tools {
namespace {

constexpr std::size_t shown_of_long = 80;  ///< characters of a line that is too long; its row is unreadable

}  // namespace

Client::~Client() {
  if (is_socket_) ::close(in_);
}

void Client::end() {
  ended_ = true;
  text_.clear();
  at_ = 0;
}

void Client::read() {
  std::array<char, 65536> bytes{};
  const ssize_t count = ::read(in_, bytes.data(), bytes.size());
  if (count > 0) take({bytes.data(), static_cast<std::size_t>(count)});
  if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) {
    ended_ = true;
    if (text_.size() > at_ && text_.back() != '\n') text_ += '\n';
  }
}

void Client::take(std::string_view fresh) {
  if (skipped_ > 0) {
    const std::size_t line_end = std::min(fresh.find('\n'), fresh.size());
    skipped_ += line_end;
    if (skipped_ > longest_skipped) {
      core::warn(fmt::format("serve: a line without an end after {} characters; its sender is not heard any more",
                             longest_skipped));
      return end();
    }
    fresh.remove_prefix(line_end);
    if (fresh.empty()) return;
    skipped_ = 0;
  }
  text_.append(fresh);
  const std::size_t newest = text_.rfind('\n');
  const std::size_t open = text_.size() - (newest == std::string::npos ? at_ : newest + 1);
  if (open <= longest_row) return;
  core::warn(fmt::format("serve: a line of more than {} characters is no row", longest_row));
  skipped_ = open;
  text_.resize(text_.size() - open + shown_of_long);
}

std::string Client::line() {
  const std::size_t end = text_.find('\n', at_);
  if (end == std::string::npos) {
    text_.erase(0, at_);
    at_ = 0;
    return {};
  }
  const bool is_too_long = end + 1 - at_ > longest_row;
  std::string line = text_.substr(at_, is_too_long ? shown_of_long : end + 1 - at_);
  at_ = end + 1;
  if (is_too_long) {
    core::warn(fmt::format("serve: a line of more than {} characters is no row", longest_row));
    line += '\n';
  }
  return line;
}

void Client::write(const std::string& text) {
  const bool whole = is_socket_
                         ? ::send(out_, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL) == std::ssize(text)
                         : write_whole(text);
  if (whole) return;
  if (!is_socket_) throw core::InputError("standard output", std::strerror(errno), "a pipe or file with room");
  if (!ended_) core::warn("serve: the client does not take its answers; it is not served any more");
  end();
}

bool Client::write_whole(const std::string& text) const {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = ::write(out_, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR) return false;
    if (count < 0) core::check_interrupt();
    if (count > 0) done += count;
  }
  return true;
}

Listener::Listener(const std::filesystem::path& path) : path_(path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = path.string();
  if (name.size() >= sizeof address.sun_path) {
    throw core::InputError("--socket", fmt::format("a path of {} characters", name.size()),
                           fmt::format("at most {}", sizeof address.sun_path - 1));
  }
  std::memcpy(address.sun_path, name.data(), name.size());
  const auto* where = reinterpret_cast<const sockaddr*>(&address);
  const auto fresh = [] { return ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); };
  descriptor_ = fresh();
  const bool taken = ::connect(descriptor_, where, sizeof address) == 0;
  ::close(descriptor_);
  if (taken) throw core::InputError(name, "another process listens there", "one `serve` a socket");
  std::error_code none;
  if (std::filesystem::is_socket(path, none)) std::filesystem::remove(path, none);
  descriptor_ = fresh();
  if (::bind(descriptor_, where, sizeof address) == 0 && ::listen(descriptor_, 4) == 0) return;
  const int reason = errno;
  ::close(descriptor_);
  throw core::InputError(name, std::strerror(reason), "a new name in a folder that may be written");
}

Listener::~Listener() {
  ::close(descriptor_);
  std::error_code none;
  std::filesystem::remove(path_, none);
}

}  // namespace thermotwin::tools
