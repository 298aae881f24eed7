// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The page of `serve`: the machine in 3-D with the model's temperatures, offsets with their standard deviations, the
// guard, sensors with predictions, and the last 24 h. It follows by server-sent events; /now and /history give the same
// as JSON.

#include <filesystem>

namespace thermotwin::tools {

/// Serves the page on 127.0.0.1 and reads moments, a line of JSON each, from standard input until it ends.
/// @param model_file  scene.bin beside it has the skin of the machine, if any
/// @param day_file  keeps the last 24 h for the next start; empty: they are not kept
/// @throws InputError where the port is taken or the model cannot be read
void show_page(const std::filesystem::path& model_file, const std::filesystem::path& day_file, int port);

}  // namespace thermotwin::tools
