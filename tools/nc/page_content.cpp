// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/page_content.h"

namespace thermotwin::tools {

PageContent::PageContent(const nc::AxisMotion& motion, const compensation::OffsetLimits& limits)
    : beyond_(limits),
      samples_(motion, [this](const nc::PathPoint& point) {
        path_.add(point);
        errors_.add(point);
      }) {}

void PageContent::add(const nc::PredictedMove& move) {
  beyond_.add(move);
  if (move.timed->element.source) {
    samples_.add(move);
    return;
  }
  nc::PathPoint point;
  point.error_um = move.error_um;
  point.std_um = move.field->error_std(move.std_um);
  point.time = move.time;
  point.rapid = move.timed->element.rapid;
  errors_.add(point);
}

std::string PageContent::page(const nc::Report& report, const nc::Operations& operations, const nc::Parts& parts) {
  path_.finish();
  return nc::report_page(report, path_, errors_, operations, beyond_, parts);
}

}  // namespace thermotwin::tools
