// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The machine of rods with eight patches at the corners of its column.

#include "reduction/model/reduced_model.h"
#include "tests/machines/rods_record.h"

namespace thermotwin::diagnosis {

inline reduction::ReducedModel boxed_column() {
  reduction::ReducedModel model;
  model.machine = lumped::machine();
  for (const double z : {0.0, 1.0}) {
    for (const double x : {-0.2, 0.2}) {
      for (const double y : {-0.1, 0.1}) {
        reduction::Patch patch;
        patch.surface.body = "column";
        patch.centre = {x, y, z};
        model.patches.items.push_back(patch);
      }
    }
  }
  return model;
}

}  // namespace thermotwin::diagnosis
