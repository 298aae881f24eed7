// SPDX-License-Identifier: GPL-2.0-or-later
#include "nc/rs274/stream.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace thermotwin::nc::rs274 {

namespace {

constexpr std::size_t room = 1U << 16U, longest_record = 8 + 65535;
std::array<char, room + longest_record> buffer;
int output = STDOUT_FILENO;
volatile std::size_t used = 0;
volatile std::uint32_t line_now = 0;
std::array<std::array<double, 16>, 16> last{};
std::array<std::uint16_t, 16> known{};
Limits most;
std::uint64_t moves = 0, idle = 0;
bool ran = false;

/// A record counts once it is whole.
void append(const Head& head, const void* body, std::size_t bytes) {
  std::memcpy(buffer.data() + used, &head, sizeof head);
  std::memcpy(buffer.data() + used + sizeof head, body, bytes);
  used = used + sizeof head + bytes;
  if (used > room) flush();
}

}  // namespace

void take_standard_output() {
  output = dup(STDOUT_FILENO);
  const int nowhere = open("/dev/null", O_WRONLY);
  if (output < 0 || nowhere < 0) _exit(1);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
}

void flush() {
  std::size_t at = 0;
  while (at < used) {
    const ssize_t written = write(output, buffer.data() + at, used - at);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(1);  // nobody listens
    at += written;
  }
  used = 0;
}

void write_values(Kind kind, std::uint8_t index, std::uint32_t line, const double* values, int count) {
  const auto k = static_cast<std::size_t>(kind);
  const bool whole = kind == Kind::offset || kind == Kind::setting;
  std::array<double, 16> changed;
  std::uint16_t mask = 0;
  std::size_t n = 0;
  for (int i = 0; i < count; ++i) {
    const std::uint16_t bit = 1U << i;
    // Bits, so that -0 and 0 differ and the host has what was meant.
    if (!whole && (known[k] & bit) != 0 && std::memcmp(&last[k][i], &values[i], sizeof(double)) == 0) continue;
    last[k][i] = values[i];
    changed[n++] = values[i];
    mask |= bit;
  }
  known[k] |= mask;
  append({kind, index, mask, line}, changed.data(), n * sizeof(double));
  ran = true;  // a skipped line calls nothing
  if (kind == Kind::traverse || kind == Kind::feed || kind == Kind::arc || kind == Kind::tap || kind == Kind::probe) {
    idle = 0;
    if (++moves > most.moves) stop(Stop::moves, "");
  }
}

void write_setting(Setting setting, double value, double second) {
  const std::array<double, 2> values{value, second};
  write_values(Kind::setting, static_cast<std::uint8_t>(setting), line_now, values.data(), 2);
}

void write_text(Kind kind, std::uint8_t index, std::uint32_t line, std::string_view text) {
  const std::string_view head = text.substr(0, 60000);
  append({kind, index, static_cast<std::uint16_t>(head.size()), line}, head.data(), head.size());
}

void set_limits(const Limits& limits) { most = limits; }

void begin_block(std::uint32_t line, int depth) {
  line_now = line;
  ran = false;
  append({Kind::block, static_cast<std::uint8_t>(std::clamp(depth, 0, 255)), 0, line}, nullptr, 0);
  if (++idle > most.idle_blocks) stop(Stop::idle_blocks, "");
}

void block_ran() { ran = true; }
bool has_run() { return ran; }
std::uint32_t current_line() { return line_now; }

void stop(Stop reason, std::string_view text) {
  write_text(Kind::error, static_cast<std::uint8_t>(reason), line_now, text);
  flush();
  _exit(0);
}

}  // namespace thermotwin::nc::rs274
