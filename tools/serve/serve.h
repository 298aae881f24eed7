// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// `serve MODEL`: runs the model beside a control for months, as three processes. The front (front/) owns the guard, and
// standard input or a local socket; it uses no library of the model. The model process is `compensate` with a saved
// state. The page process shows what front and model do. The front starts a model or page process again that has died.

#include "tools/options.h"

namespace thermotwin::tools {

enum class ServePart { whole, model, page };

struct ServeOptions : CompensateOptions {
  std::filesystem::path socket;  ///< local socket; one client at a time sends rows; empty: standard input
  int port = 0;                  ///< of the page on 127.0.0.1; 0: no page
  ServePart part = ServePart::whole;
};

/// Becomes the front (ServePart::whole), or runs the process of `part`, which the front has started.
void serve(const ServeOptions& options);

}  // namespace thermotwin::tools
