// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reserves the buffers of OpenBLAS, which otherwise waits for memory without end while fork() and exit() wait for it.

namespace thermotwin::core {

/// Makes the buffers that OpenBLAS will ask for, one per thread of the pool, if the address space is limited
/// (ulimit -v). It acts once and has to be called before the first fork and the first work of the BLAS.
/// @throws SolverError if there is no memory for them
void reserve_blas_buffers();

}  // namespace thermotwin::core
