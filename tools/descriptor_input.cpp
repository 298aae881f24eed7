// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/descriptor_input.h"

#include <cerrno>
#include <poll.h>
#include <system_error>
#include <unistd.h>

#include "core/progress.h"

namespace thermotwin::tools {

DescriptorInput::int_type DescriptorInput::underflow() {
  // A signal that comes just before poll would not wake it, hence a time limit.
  constexpr int patience_ms = 200;
  for (;;) {
    core::check_interrupt();
    pollfd state{descriptor_, POLLIN, 0};
    const int ready = ::poll(&state, 1, patience_ms);
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    const ssize_t count = ::read(descriptor_, buffer_.data(), buffer_.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (count < 0) throw std::system_error(errno, std::generic_category(), "read");
    if (count == 0) return traits_type::eof();
    setg(buffer_.data(), buffer_.data(), buffer_.data() + count);
    return traits_type::to_int_type(buffer_.front());
  }
}

}  // namespace thermotwin::tools
