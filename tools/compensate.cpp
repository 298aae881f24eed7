// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/compensator.h"

#include <fmt/format.h>

#include <fstream>
#include <iostream>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "reduction/model_file.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {

void compensate(const CompensateOptions& options) {
  const reduction::ReducedModel model = reduction::read_model(options.model);
  compensation::CompensatorOptions settings;
  settings.use_sensors = !options.no_sensors;
  settings.step_s = options.step_s;
  compensation::Compensator compensator(model, settings);

  std::ios::sync_with_stdio(false);
  std::ifstream file;
  if (options.in != "-") {
    file.open(options.in, std::ios::binary);
    if (!file) throw core::InputError(options.in, "cannot be read", "a CSV file, or - for standard input");
  }
  std::istream& in = options.in == "-" ? std::cin : file;
  const std::string in_name = options.in == "-" ? "standard input" : options.in;

  const Stopwatch time;
  long rows = 0;
  if (options.out == "-") {
    // A control waits for each answer: rows are flushed one by one.
    rows = compensation::compensate_stream(compensator, model.machine, in, in_name, std::cout, true);
  } else {
    core::write_file_by(options.out, [&](const std::filesystem::path& temporary) {
      std::ofstream out(temporary, std::ios::binary);
      rows = compensation::compensate_stream(compensator, model.machine, in, in_name, out, false);
      out.flush();
      if (!out) throw core::InputError(options.out.string(), "could not be written", "a place with room on the disk");
    });
  }
  core::log_line(fmt::format("compensate: {} rows in {:.2f} s ({:.0f} rows/s), order {}, peak memory {:.2f} GiB", rows,
                             time.seconds(), static_cast<double>(rows) / time.seconds(), model.system.order(),
                             peak_memory_GiB()));
}

}  // namespace thermotwin::tools
