// SPDX-License-Identifier: GPL-3.0-or-later
// thermotwin_front: what `thermotwin serve` becomes. usage: thermotwin_front OPTIONS (JSON, front_options.h)

#include <nlohmann/json.hpp>

#include <exception>
#include <iostream>

#include "core/error.h"
#include "core/process.h"
#include "core/progress.h"
#include "tools/serve/front/front.h"

namespace {

using namespace thermotwin;

int status_of(int argc, char** argv) {
  try {
    if (argc != 2) throw core::UsageError("thermotwin_front is started by `thermotwin serve`");
    const auto options = nlohmann::json::parse(argv[1]).get<tools::FrontOptions>();
    core::set_quiet(options.quiet);
    core::install_interrupt_handler();
    tools::run_front(options);
    return 0;
  } catch (const core::Error& error) {
    std::cerr << "thermotwin: " << error.what() << "\n";
    return error.exit_status();
  } catch (const std::exception& error) {
    std::cerr << "thermotwin: " << error.what() << "\n";
    return 4;
  }
}

}  // namespace

int main(int argc, char** argv) { thermotwin::core::leave(status_of(argc, argv)); }
