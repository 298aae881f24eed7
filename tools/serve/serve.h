// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// `serve MODEL`: the model beside a control for months, as three processes. The front (front/) owns standard input or a
// local socket and the guard, and needs no library of the model. The model process is `compensate` with a state; the
// page process shows what both do. Either may die and is started again.

#include "tools/options.h"

namespace thermotwin::tools {

enum class ServePart { whole, model, page };

struct ServeOptions : CompensateOptions {
  std::filesystem::path socket;  ///< rows come from clients of it, one at a time; empty: from standard input
  int port = 0;                  ///< of the page on 127.0.0.1; 0: no page
  ServePart part = ServePart::whole;
};

/// Becomes the front, or is one of the processes that the front starts.
void serve(const ServeOptions& options);

}  // namespace thermotwin::tools
