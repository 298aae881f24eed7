// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Signals that end the program, taken by a thread of their own. Every other thread blocks them: a library that installs
// a handler while it works (METIS does so for SIGTERM, and jumps) never gets them. Children of fork receive them, those
// of posix_spawn with open_ending_signals. A program that exec puts in place of this one has to take them itself.

#include <spawn.h>

namespace thermotwin::core {

/// Blocks SIGINT and SIGTERM in all threads and calls the function with the number of each that comes, from one thread.
/// It must be async-signal-safe: a thread that a library opens for them runs it as a handler. Call it once.
/// @throws std::system_error if the thread cannot be started
void take_ending_signals(void (*take)(int));

/// Lets a program that posix_spawn begins receive them.
void open_ending_signals(posix_spawnattr_t& attributes);

}  // namespace thermotwin::core
