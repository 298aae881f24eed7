/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_TWIN_JOBS_H
#define THERMOTWIN_TWIN_JOBS_H
/* The long work of a twin, one job at a time: a step of the state; a correction (operator of the interval, observer,
 * deviations, outputs); the start (heats of a day's work, modes of the machine at three operating points, first
 * readings, how what they left fades, deviations, outputs).
 *
 * A slice reads the twin's state alone and writes what its job needs into the state or the work block; what the latter
 * holds of an unfinished job is found again by tt_redo_job. */

#include "compensation/control/twin.h"

#ifdef __cplusplus
extern "C" {
#endif

void tt_lay_jobs(tt_twin* t, tt_arena* state, tt_arena* work);
void tt_reset_jobs(tt_twin* t);

tt_moment tt_moment_of(const tt_twin* t);
/* How far the row is ahead of the last step, in steps: at most 1, and while a job runs as much more, up to 1.5. */
double tt_share_ahead(const tt_twin* t);
void tt_read_predicted(tt_twin* t); /* sensors of the state */
/* Chillers and coefficients at a row, with the sensors where they are trusted. */
void tt_start_clock(tt_twin* t, const double* row);

void tt_begin_step(tt_twin* t, double step_s, double end); /* from mean_row */
void tt_begin_correction(tt_twin* t);
void tt_begin_start(tt_twin* t); /* readings of the first row are taken */
int tt_correction_due(const tt_twin* t);
/* What was learnt shows in outputs and deviations; a job of its own. */
void tt_begin_showing(tt_twin* t);

int tt_job_slices(const tt_twin* t); /* of the job in progress; of the start about as many */
void tt_work_on(tt_twin* t, int slices);
void tt_finish_job(tt_twin* t);
void tt_redo_job(tt_twin* t);

#ifdef __cplusplus
}
#endif
#endif
