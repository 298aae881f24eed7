// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Phenomenological differential equation of one location error (Gebhardt 2014, 5.26 and 5.27):
//   dy/dt = s (p1 y + sum_i p2_i u_i + p3) + (1 - s) (p4 y + sum_i p5_i u_i + p6),
// u speeds or drive powers that hold from row to row, s = 1 while an axis or the spindle moves. With
// temperatures as inputs the two sets stand for heating and cooling (as in Mares et al. 2019):
// s = 1 while the mean temperature is above what it was half an hour ago. Without a switch, or where
// the training data know one state only, there is one set. Given p1 and p4 the rest is linear and
// solved exactly; p1 and p4 are searched by simplex (as in the source) and by gradient.

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

enum class SwitchBy { nothing, motion, warming };
enum class Search { simplex, gradient };

struct PhenomenologicalOptions {
  SwitchBy switch_by = SwitchBy::nothing;
  Search search = Search::simplex;
};
std::unique_ptr<ChannelModel> make_phenomenological(const PhenomenologicalOptions& options);

}  // namespace thermotwin::compensation
