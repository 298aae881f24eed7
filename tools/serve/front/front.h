// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The front of `serve`: owns the socket or standard input and output, and the guard. It needs no library of the model,
// waits for nobody, and keeps the model process and that of the page alive.

#include "tools/serve/front/front_options.h"

namespace thermotwin::tools {

/// Returns when standard input ends.
/// @throws InputError for a model, state or header that cannot be used at the start; Interrupted
void run_front(const FrontOptions& options);

}  // namespace thermotwin::tools
