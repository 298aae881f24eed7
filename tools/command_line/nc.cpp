// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/nc.h"

#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"

namespace thermotwin::tools {

void add_nc(CLI::App& app) {
  const auto options = std::make_shared<NcOptions>();
  NcOptions& nc = *options;
  CLI::App* verb =
      add_verb(app, "nc", "Computes time, loads and TCP error along an NC program, and writes the corrected program.",
               "thermotwin nc out/model.rom.h5 part.ngc --control linuxcnc --out out", options, &tools::nc);
  verb->add_option("MODEL", nc.model,
                   "Reduced model (model.rom.h5). A case folder or machine.toml gives time and loads only.")
      ->required();
  verb->add_option("PROGRAM", nc.program, "NC program, as LinuxCNC's interpreter reads it.")->required();
  verb->add_option("--control", nc.control, "Control profile: linuxcnc, fanuc, siemens or a TOML file.")
      ->capture_default_str();
  verb->add_option("--tools", nc.tools, "Tool table of LinuxCNC, lengths in mm.");
  verb->add_option("--folder", nc.folder,
                   "Folder below which the program and its subprograms are (default: that of the program).");
  auto* log =
      verb->add_option("--log", nc.log,
                       "Log of a control (CSV: time_s and one of line and block): its times in place of the planner's.")
          ->check(CLI::ExistingFile);
  verb->add_option("--time-factor", nc.time_factor,
                   "Factor on the planned times of moves and dwells, where the control is known to take longer or "
                   "shorter; --pause stays.")
      ->check(CLI::Range(0.1, 10.0))
      ->capture_default_str()
      ->excludes(log);
  verb->add_option("--process", nc.process,
                   "Heat of the cutting process (TOML): power of tools, shares of chips, tool, workpiece and fluid.")
      ->check(CLI::ExistingFile);
  verb->add_option("--start", nc.start, "Positions before the program, such as X=0,Y=0,Z=100 (default: home).");
  verb->add_option("--start-C", nc.start_C, "Uniform temperature of the machine before the program.")
      ->capture_default_str();
  auto* rested =
      verb->add_flag("--rested", nc.rested,
                     "The machine has stood off until all of it is at --start-C within 0.5 K. Without this option the "
                     "standard deviation contains the heat of any earlier work.");
  verb->add_option("--row-s", nc.row_s, "Duration of each row of rows.csv, s.")->capture_default_str();
  auto* state = verb->add_option("--state", nc.state,
                                 "State of `compensate --state`: the machine before the program (default: at "
                                 "--start-C). The program begins where the axes stood, unless --start says otherwise.")
                    ->excludes(rested);
  verb->add_option("--after", nc.after_s,
                   "Time from the state to the program, s (default: --row-s). Beyond 300 s the machine counts as off.")
      ->check(CLI::Range(0.0, 604800.0))
      ->needs(state);
  verb->add_option("--step", nc.step_s, "--step of the `compensate` that saved the state, s.")
      ->check(positive_number())
      ->capture_default_str()
      ->needs(state);
  verb->add_option("--largest-offset", nc.largest_um,
                   "Largest offset of an axis, um: --rewrite refuses a larger one. With --state: that of the "
                   "`compensate` that saved it.")
      ->check(positive_number());
  verb->add_option("--offset-rate", nc.rate_um_s,
                   "Largest rate of an offset, um/s: --rewrite refuses a larger one. With --state: that of the "
                   "`compensate` that saved it.")
      ->check(positive_number());
  verb->add_option("--order", nc.order,
                   "Number of states of the model that are kept, from the first on (default: all).")
      ->check(positive_number());
  verb->add_option("--rewrite", nc.rewrite,
                   "path: corrected coordinates; shift: updates of the work offset at retracted moves.")
      ->check(CLI::IsMember({"path", "shift"}));
  verb->add_option("--tolerance", nc.tolerance_um, "Tolerance of the rewritten path, um.")
      ->check(positive_number())
      ->capture_default_str();
  verb->add_option("--repeat", nc.repeat,
                   "Number of parts, one after the other; the rewritten program is that of the last one.")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  verb->add_option("--pause", nc.pause_s, "Pause between two parts, s.")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  verb->add_option("--imprint", nc.imprint,
                   "Number of the tool of the finishing pass. The error that it leaves in the surface becomes a table, "
                   "a picture and imprint.csv.")
      ->check(CLI::Range(0, 99999));
  verb->add_flag("--no-blocks", nc.no_blocks, "Leave out blocks.csv, a row for each move.");
  verb->add_flag("--no-page", nc.no_page, "Leave out report.html, the error along the path.");
}

}  // namespace thermotwin::tools
