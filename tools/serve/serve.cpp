// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/serve.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <arpa/inet.h>
#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>

#include "core/error.h"
#include "tools/serve/front/front_options.h"
#include "tools/serve/page.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

/// Said at the start, while somebody looks; later a page without a port is a warning.
void require_free(int port) {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool bound = ::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const int reason = errno;
  ::close(descriptor);
  if (bound) return;
  throw core::InputError(fmt::format("--port {}", port), std::strerror(reason),
                         "a port of 127.0.0.1 that no other program has");
}

fs::path own_program() {
  std::error_code ignored;
  return fs::read_symlink("/proc/self/exe", ignored);
}

fs::path front_program() {
  const fs::path here = own_program().parent_path();
  for (const fs::path& folder : {here, here / THERMOTWIN_HELPERS}) {
    const fs::path path = folder / "thermotwin_front";
    if (::access(path.c_str(), X_OK) == 0) return path;
  }
  throw core::SolverError("serve: thermotwin_front is not beside this program; build or install it whole");
}

std::vector<std::string> model_command(const ServeOptions& options) {
  std::vector<std::string> command = {own_program(), "serve", options.model.string(), "--part", "model"};
  const auto add = [&](const char* name, const std::string& value) { command.insert(command.end(), {name, value}); };
  add("--threads", std::to_string(options.threads));
  add("--step", fmt::format("{}", options.step_s));
  add("--start-C", fmt::format("{}", options.start_C));
  add("--probe-std", fmt::format("{}", options.probe_std_um));
  if (options.largest_um > 0) add("--largest-offset", fmt::format("{}", options.largest_um));
  if (options.rate_um_s > 0) add("--offset-rate", fmt::format("{}", options.rate_um_s));
  if (options.order > 0) add("--order", std::to_string(options.order));
  if (options.no_sensors) command.emplace_back("--no-sensors");
  if (options.probed_compensated) command.emplace_back("--probed-compensated");
  if (!options.socket.empty()) add("--socket", options.socket.string());
  if (options.quiet) command.emplace_back("--quiet");
  return command;
}

fs::path state_of(const ServeOptions& options) {
  return options.state.empty() ? options.model.parent_path() / "serve.state" : options.state;
}

std::vector<std::string> page_command(const ServeOptions& options) {
  if (options.port == 0) return {};
  std::vector<std::string> command = {own_program(), "serve", options.model.string(), "--part", "page"};
  command.insert(command.end(), {"--port", std::to_string(options.port), "--state", state_of(options).string()});
  if (options.quiet) command.emplace_back("--quiet");
  return command;
}

void become_front(const ServeOptions& options) {
  if (options.json) throw core::UsageError("serve has no summary for --json; allowed: --json-lines");
  if (options.out != "-") throw core::UsageError("serve answers on standard output or --socket; allowed: no --out");
  if (!fs::is_regular_file(options.model))
    throw core::InputError(options.model.string(), "is no file", "a reduced model, model.rom.h5");
  if (options.port > 0) require_free(options.port);
  const fs::path program = front_program();
  const FrontOptions front = {.model = options.model,
                              .state = state_of(options),
                              .socket = options.socket,
                              .json_lines = options.json_lines,
                              .quiet = options.quiet,
                              .model_command = model_command(options),
                              .page_command = page_command(options)};
  const std::string text = nlohmann::json(front).dump();
  ::execl(program.c_str(), program.c_str(), text.c_str(), nullptr);
  throw core::SolverError(fmt::format("serve: {}: {}", program.string(), std::strerror(errno)));
}

}  // namespace

void serve(const ServeOptions& options) {
  switch (options.part) {
    case ServePart::whole: become_front(options); return;
    case ServePart::page: show_page(options.model, options.state.string() + ".day", options.port); return;
    case ServePart::model: break;
  }
  CompensateOptions rows = options;
  rows.json_lines = rows.announce = true;
  if (!options.socket.empty()) rows.in_name = "rows of " + options.socket.string();
  compensate(rows);
}

}  // namespace thermotwin::tools
