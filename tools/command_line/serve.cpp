// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/serve.h"

#include <map>

#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"

namespace thermotwin::tools {
namespace {

void add_model_options(CLI::App& verb, ServeOptions& serve) {
  verb.add_flag("--no-sensors", serve.no_sensors, "Ignore the temperature sensors.");
  verb.add_option("--order", serve.order,
                  "Number of states of the model that are kept, from the first on (default: all).")
      ->check(positive_number());
  verb.add_option("--step", serve.step_s, "Longest step of the thermal state, s.")
      ->check(positive_number())
      ->capture_default_str();
  verb.add_option("--start-C", serve.start_C,
                  "Uniform temperature of the machine at a start without state, degC; with sensors it is estimated "
                  "from their first readings.")
      ->check(start_temperature())
      ->capture_default_str();
  verb.add_option("--largest-offset", serve.largest_um,
                  "Limit of each offset, um (default: twice the largest offset at the model's operating points).")
      ->check(positive_number());
  verb.add_option(
          "--offset-rate", serve.rate_um_s,
          "Limit of each offset's rate of change, um/s (default: the largest offset in 300 s, plus axis moves).")
      ->check(positive_number());
  verb.add_option("--probe-std", serve.probe_std_um,
                  "Standard deviation of the values in the columns probe_dx_um, probe_dy_um and probe_dz_um, um.")
      ->check(CLI::Range(0.001, 1e5))
      ->capture_default_str();
  verb.add_flag("--probed-compensated", serve.probed_compensated,
                "The values were probed with compensation active, that is, with the offsets of the row before.");
}

}  // namespace

void add_serve(CLI::App& app) {
  const auto options = std::make_shared<ServeOptions>();
  ServeOptions& serve = *options;
  CLI::App* verb = add_verb(
      app, "serve",
      "Runs the model beside a control for months: rows of CSV in, offsets out. A model process that dies is started "
      "again.",
      "thermotwin serve out/model.rom.h5 --socket /run/twin.socket --port 8080\n"
      "  thermotwin serve out/model.rom.h5 < rows.csv",
      options, &tools::serve);
  verb->add_option("MODEL", serve.model, "Reduced model model.rom.h5; a new file of this name is taken over.")
      ->required();
  verb->get_option("--out")->description("Not used: answers go to standard output, or to the client of --socket.");
  verb->add_option("--state", serve.state, "File of the whole state (default: serve.state beside the model).");
  verb->add_option("--socket", serve.socket,
                   "Local socket for rows and answers, one client at a time (default: standard input and output).");
  verb->add_option("--port", serve.port, "Port of a page on 127.0.0.1 (default: no page).")
      ->check(CLI::Range(1, 65535));
  verb->add_flag("--json-lines", serve.json_lines, "Answer with a line of JSON a row instead of CSV.");
  add_model_options(*verb, serve);
  const std::map<std::string, ServePart> parts = {{"model", ServePart::model}, {"page", ServePart::page}};
  verb->add_option("--part", serve.part, "Process that the front starts.")
      ->transform(CLI::CheckedTransformer(parts))
      ->group("");
}

}  // namespace thermotwin::tools
