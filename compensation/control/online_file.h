// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The file of online data beside a model: model.online beside model.rom.h5. The first start writes it. It is believed
// only where all of this holds:
//   - its checksum, sizes and numbers are right;
//   - this build of the program has derived it;
//   - the last line of the model file, the hash of its content, is the one that it was derived from;
//   - the model file has the size, number and times of writing that it had when its content was checked. Where it has
//     others (a copy of the folder, a file damaged since), its content is checked again, a piece at a time.
// Else the model file is read, with an error where that is damaged, and the file is written anew. The file is read, not
// mapped: what was checked stays as it is when somebody copies another file over it.

#include <array>
#include <cstdint>
#include <filesystem>

#include "compensation/control/online_data.h"

namespace thermotwin::compensation {

struct OnlineSource {
  std::filesystem::path model;  ///< model.rom.h5
  std::int64_t order = 0;       ///< of the model; 0: its own
  std::filesystem::path state;  ///< its folder takes the file where that of the model cannot be written; empty: none
};

/// @return the file beside the model: model.online, or model.order60.online
std::filesystem::path online_file(const OnlineSource& source);
/// @return size, number, and times of the last change of content and of anything, ns; all 0: no such file, or one that
///   has changed so lately that another change might have the same time
std::array<std::int64_t, 4> file_stamp(const std::filesystem::path& file);

/// Reads the file, or the model where the file is not to be believed; a line on stderr says so.
/// @throws InputError as reduction::read_model and model_of_order
OnlineData online_data(const OnlineSource& source);

}  // namespace thermotwin::compensation
