// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/blas_buffers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <mutex>
#include <sys/resource.h>
#include <vector>

#include "core/error.h"
#include "core/thread_pool.h"

namespace thermotwin::core {

namespace {

constexpr std::size_t buffer_bytes = (128u << 20) + (1u << 16);  // as OpenBLAS asks for it

void make_buffers() {
  using Allocate = void* (*)(int);
  using Free = void (*)(void*);
  static const auto allocate = reinterpret_cast<Allocate>(dlsym(RTLD_DEFAULT, "blas_memory_alloc"));
  static const auto release = reinterpret_cast<Free>(dlsym(RTLD_DEFAULT, "blas_memory_free"));
  rlimit limit{};
  if (!allocate || !release || getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  std::vector<void*> buffers(thread_count());
  for (void*& buffer : buffers) buffer = std::malloc(buffer_bytes);
  const bool room = std::count(buffers.begin(), buffers.end(), nullptr) == 0;
  for (void* buffer : buffers) std::free(buffer);
  if (!room) {
    throw SolverError(
        fmt::format("not enough memory for the BLAS: {} buffers of 128 MiB do not fit into the {} MiB of ulimit -v; "
                    "--threads 1 needs one",
                    buffers.size(), limit.rlim_cur >> 20));
  }
  for (void*& buffer : buffers) buffer = allocate(0);
  for (void* buffer : buffers) release(buffer);  // OpenBLAS keeps them for its next calls
}

}  // namespace

void reserve_blas_buffers() {
  static std::once_flag once;
  std::call_once(once, make_buffers);
}

}  // namespace thermotwin::core
