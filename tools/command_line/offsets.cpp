// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_offsets(CLI::App& app) {
  const auto options = std::make_shared<OffsetsOptions>();
  OffsetsOptions& offsets = *options;
  CLI::App* verb =
      add_verb(app, "offsets", "Converts location errors of any kinematic chain to axis offsets, row by row.",
               "thermotwin offsets --chain \"V [w C' B' b Y X Z (C1) t]\" --in errors.csv --out offsets.csv", options,
               &tools::offsets);
  verb->add_option("--chain", offsets.chain,
                   "Kinematic chain after ISO 10791-1, from the workpiece w over the bed b to the tool t.")
      ->required();
  verb->add_option("--in", offsets.in,
                   "CSV file of time_s, positions (X_mm, B_deg), functional point (point_x_mm, default 0) and errors "
                   "(X0C_um, A0C_um_per_m, R0T_um).")
      ->required();
  verb->get_option("--out")->description("CSV file of offsets, or - for standard output.")->group("Options");
  verb->add_flag("--orientation", offsets.orientation, "Use rotary axes for the functional orientation as well.");
  verb->add_option("--axes", offsets.axes, "Axes that may be used, e.g. X,Y,Z (default: all of the chain).")
      ->delimiter(',');
  verb->add_option("--with-letter", offsets.along_letter,
                   "Axes that move the workpiece in the direction of their letter instead of against it, e.g. B,C.")
      ->delimiter(',');
  verb->add_option("--table-radius", offsets.table_radius_mm, "Radius at which R0T is stated, mm.")
      ->check(positive_number())
      ->capture_default_str();
}

}  // namespace thermotwin::tools
