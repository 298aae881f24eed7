// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Control profiles that come with the program.

namespace thermotwin::nc {

extern const char* const linuxcnc_profile;
extern const char* const fanuc_profile;
extern const char* const siemens_profile;

}  // namespace thermotwin::nc
