// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// OpenBLAS, where it is the BLAS in use, waits for memory without end, and fork() and exit() wait for its threads.

namespace thermotwin::core {

/// Where the address space is limited (ulimit -v), makes the buffers that OpenBLAS asks for once it has
/// work, one a thread of the pool. Done once, before the first fork and the first work of the BLAS.
/// @throws SolverError if there is no room for them
void reserve_blas_buffers();

}  // namespace thermotwin::core
