// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/import_process.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <new>
#include <poll.h>
#include <string_view>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include "core/blas_buffers.h"
#include "core/error.h"
#include "core/progress.h"
#include "mesh/import/mesh_cache.h"

namespace thermotwin::mesh {

namespace {

// First byte of what the child sends.
enum class Answer : char {
  mesh = 'm',
  mesher_error = 'f',
  mesh_error = 'e',
  input_error = 'i',
  solver_error = 's',
  no_memory = 'n'
};
constexpr int status_of_no_memory = 4;  // as core/process ends the program where memory runs out

double default_memory() { return 2.0 * ::sysconf(_SC_PHYS_PAGES) * ::sysconf(_SC_PAGE_SIZE); }

void lower_limit(int resource, double to) {
  rlimit limit{};
  if (::getrlimit(static_cast<__rlimit_resource_t>(resource), &limit) != 0) return;
  const auto wanted = static_cast<rlim_t>(to);
  if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur <= wanted) return;
  limit.rlim_cur = limit.rlim_max == RLIM_INFINITY ? wanted : std::min(wanted, limit.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
}

bool is_child = false;

void send(int to, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::write(to, bytes.data(), bytes.size());
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) ::_exit(1);
    bytes.remove_prefix(sent);
  }
}

[[noreturn]] void be_the_child(int to, pid_t parent, const ImportLimits& limits, const std::function<TetMesh()>& work) {
  // A signal from the terminal reaches the parent too, which tidies up.
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  lower_limit(RLIMIT_CORE, 0);
  lower_limit(RLIMIT_CPU, limits.processor_s);
  is_child = true;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their shadow needs the address space
  lower_limit(RLIMIT_AS, limits.memory_bytes > 0.0 ? limits.memory_bytes : default_memory());
#endif
  const auto answer = [&](Answer kind, std::string_view bytes) {
    const char first = static_cast<char>(kind);
    send(to, {&first, 1});
    send(to, bytes);
    ::_exit(0);
  };
  try {
    answer(Answer::mesh, pack_mesh(work()));
  } catch (const MesherError& error) {
    answer(Answer::mesher_error, error.what());
  } catch (const core::MeshError& error) {
    answer(Answer::mesh_error, error.what());
  } catch (const core::InputError& error) {
    answer(Answer::input_error, error.what());
  } catch (const std::bad_alloc&) {
    answer(Answer::no_memory, "");
  } catch (const std::exception& error) {
    answer(Answer::solver_error, error.what());
  }
  ::_exit(1);
}

/// Reads to the end. @throws Interrupted
std::string receive(int from) {
  std::string bytes;
  std::array<char, 1 << 16> buffer;
  while (true) {
    core::check_interrupt();
    pollfd ready{from, POLLIN, 0};
    if (::poll(&ready, 1, 100) <= 0) continue;
    const ssize_t size = ::read(from, buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return bytes;
    bytes.append(buffer.data(), size);
  }
}

/// An error with the words of another one, which its constructor put together.
template <class Error>
[[noreturn]] void throw_again(const std::string& text) {
  const std::string allowed = "; allowed: ";
  const std::size_t second = text.find(allowed), first = text.rfind(": ", second);
  if (second == std::string::npos || first == std::string::npos) throw Error("import", text, "a readable file");
  throw Error(text.substr(0, first), text.substr(first + 2, second - first - 2), text.substr(second + allowed.size()));
}

std::string end_of(int status, double seconds) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    return fmt::format("not read and meshed within {:.0f} s of processor time", seconds);
  if (WIFSIGNALED(status))
    return fmt::format("reading or meshing it crashed the library that does so ({})", ::strsignal(WTERMSIG(status)));
  return fmt::format("reading or meshing it ended early (status {})", WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

/// Ends the child however this scope is left.
class Child {
public:
  Child(pid_t pid, int from) : pid_(pid), from_(from) {}
  ~Child() {
    ::close(from_);
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  int wait() {
    int status = 0;
    rusage used{};
    while (::wait4(pid_, &status, 0, &used) < 0 && errno == EINTR) {}
    pid_ = -1;
    seconds_ =
        1.0 * (used.ru_utime.tv_sec + used.ru_stime.tv_sec) + 1e-6 * (used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    return status;
  }
  /// Processor time that it took.
  double seconds() const { return seconds_; }

private:
  pid_t pid_;
  int from_;
  double seconds_ = 0;
};

/// Gmsh may loop for ever where memory ends. @throws std::bad_alloc
void require_room() {
  constexpr std::size_t least = 96U << 20U;
  void* room = ::mmap(nullptr, least, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) throw std::bad_alloc();
  ::munmap(room, least);
}

}  // namespace

TetMesh mesh_in_child(const std::string& place, const ImportLimits& limits, const std::function<TetMesh()>& work) {
  core::reserve_blas_buffers();
  require_room();
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  std::fflush(nullptr);  // else the child writes it a second time
  const pid_t parent = ::getpid(), pid = ::fork();
  if (pid < 0) {
    for (const int end : ends) ::close(end);
    throw std::bad_alloc();  // no memory or no process left
  }
  if (pid == 0) {
    ::close(ends[0]);
    be_the_child(ends[1], parent, limits, work);
  }
  ::close(ends[1]);
  Child child(pid, ends[0]);
  const std::string bytes = receive(ends[0]);
  const int status = child.wait();
  if (bytes.empty() || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    if (WIFEXITED(status) && WEXITSTATUS(status) == status_of_no_memory) throw std::bad_alloc();
    const std::string allowed =
        "a file that is not damaged (write it anew from CAD, or in another format), a larger element_size_mm, or "
        "simpler geometry";
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
      throw core::MeshError(place, end_of(status, child.seconds()), allowed + ", or mesher = \"lattice\" of the body");
    throw MesherError(place, end_of(status, child.seconds()), allowed);
  }
  const std::string_view rest = std::string_view(bytes).substr(1);
  switch (static_cast<Answer>(bytes[0])) {
    case Answer::mesh:
      if (auto mesh = unpack_mesh(rest)) return std::move(*mesh);
      throw core::MeshError(place, "the meshing process returned an incomplete mesh", "a second attempt");
    case Answer::mesher_error: throw_again<MesherError>(std::string(rest));
    case Answer::mesh_error: throw_again<core::MeshError>(std::string(rest));
    case Answer::input_error: throw_again<core::InputError>(std::string(rest));
    case Answer::no_memory: throw std::bad_alloc();
    case Answer::solver_error: break;
  }
  throw core::SolverError(std::string(rest));
}

void limit_time_by(double tetrahedra) {
  constexpr double least_s = 300.0, of_one_s = 1e-3;
  if (is_child) lower_limit(RLIMIT_CPU, least_s + of_one_s * tetrahedra);
}

}  // namespace thermotwin::mesh
