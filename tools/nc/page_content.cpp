// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/page_content.h"

namespace thermotwin::tools {

PageContent::PageContent(const nc::AxisMotion& motion, const nc::BeyondLimits& beyond)
    : beyond_(beyond),
      samples_(motion, [this](const nc::PathPoint& point, const nc::Positions&) {
        path_.add(point);
        errors_.add(point);
      }) {}

void PageContent::add(const nc::PredictedMove& move) {
  if (move.timed->element.source) {
    samples_.add(move);
    return;
  }
  nc::PathPoint point;
  point.error_um = move.error_um;
  point.std_um = move.field->error_std(move.std_um);
  point.time = move.time;
  point.rapid = move.timed->element.rapid;
  point.line = move.timed->element.state.line;
  errors_.add(point);
  if (point.rapid || (worst_before_ && worst_before_->error_um.norm() >= point.error_um.norm())) return;
  worst_before_ = point;
  worst_part_ = move.timed->element.state.part + 1;
}

std::string PageContent::page(nc::Report report, const nc::Operations& operations, const nc::Parts& parts) {
  path_.finish();
  report.worst_before = worst_before_;
  report.worst_part = worst_part_;
  return nc::report_page(report, path_, errors_, operations, beyond_, parts);
}

}  // namespace thermotwin::tools
