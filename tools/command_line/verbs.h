// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The verbs of the command line, one file each: names, texts, options and what they exclude.

#include <CLI/CLI.hpp>

namespace thermotwin::tools {

void add_run(CLI::App& app);
void add_mesh(CLI::App& app);
void add_simulate(CLI::App& app);
void add_campaign(CLI::App& app);
void add_reduce(CLI::App& app);
void add_compensate(CLI::App& app);
void add_serve(CLI::App& app);
void add_offsets(CLI::App& app);
void add_measure(CLI::App& app);
void add_evaluate(CLI::App& app);
void add_diagnose(CLI::App& app);
void add_validate(CLI::App& app);
void add_study(CLI::App& app);
void add_export(CLI::App& app);
void add_nc(CLI::App& app);

}  // namespace thermotwin::tools
