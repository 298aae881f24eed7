/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_OBSERVER_START_H
#define THERMOTWIN_OBSERVER_START_H
/* What observer.c and observer_start.c share: places of the observer's numbers and flags, and its inner steps. */

#include "compensation/control/observer.h"

#ifdef __cplusplus
extern "C" {
#endif

/* numbers */
enum { corrected_at, interval_end, interval_s, drives_s, uniform_K, uniform_std, most_evidence, tt_observer_numbers };
/* flags */
enum {
  at_correction,
  at_item,
  has_observed,
  drives_taken,
  at_start,
  at_candidate,
  at_sensor,
  by_sensors,
  shapes_of_start,
  tt_observer_flags
};
/* stages of a correction; from observe on, theta and S are between two corrections */
enum { correction_none, correction_advance, correction_take, correction_failed, correction_observe, correction_done };

/* Judges the last readings beside the expected ones, (measured) K. */
void tt_observer_watch(tt_observer* o, double time, const double* expected_K, int inputs_leapt);
/* time: that what was learnt stands for */
void tt_observer_settle(tt_observer* o, const tt_moment* now, double time);

#ifdef __cplusplus
}
#endif
#endif
