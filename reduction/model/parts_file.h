// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads and writes the optional groups of model.rom.h5 that a diagnosis uses.
// docs/reference/result_files.md documents them.

#include "reduction/linear/hdf5_store.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::reduction {

void write_parts(StoreWriter& writer, const Parts& parts, const ReducedModel& model);
/// @param model  machine, order and outputs as read before  @throws InputError: sizes that disagree
std::optional<Parts> read_parts(const StoreReader& reader, const ReducedModel& model);

void write_patches(StoreWriter& writer, const Patches& patches, const mesh::Machine& machine);
/// @return no patches if the file has none  @throws InputError: sizes that disagree
Patches read_patches(const StoreReader& reader, const ReducedModel& model);

}  // namespace thermotwin::reduction
