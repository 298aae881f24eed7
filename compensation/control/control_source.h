// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Writes the online core with one model as C99 source that needs libm alone. The core's files are those that this
// program was built from (embedded at build time); numbers are hexadecimal, so that they keep their bits.

#include <filesystem>
#include <string>
#include <vector>

#include "compensation/control/control_data.h"
#include "compensation/control/model.h"

namespace thermotwin::compensation {

struct EmbeddedFile {
  const char *name, *text;
};
/// @return sources and headers of the core, and of its example
const std::vector<EmbeddedFile>& control_files();

/// @return `text` for a comment of C or of a line that # begins: on one line, and it does not end a comment of C
std::string comment_text(const std::string& text);
/// @return `text` as a literal of C, in quotes
std::string c_literal(const std::string& text);

/// @return `text` with the core's headers included from the same folder
std::string flat_includes(const std::string& text);

/// @return C source that defines `const tt_model tt_the_model`
std::string model_source(const ControlData& data);
/// @return its header: sizes of the memory blocks, and channels by name
std::string model_header(const ControlData& data, const tt_model& model);

/// Writes core, model, an example program and a README into the folder.
/// @return names of the files  @throws InputError (disk full, no permission)
std::vector<std::string> write_control_source(const std::filesystem::path& folder, const ControlData& data,
                                              const tt_model& model);

}  // namespace thermotwin::compensation
