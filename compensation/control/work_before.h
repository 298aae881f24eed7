/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_WORK_BEFORE_H
#define THERMOTWIN_WORK_BEFORE_H
/* The heat that earlier work has left in a machine at the start (the C++ class, with the equations:
 * online/work_before.h). Each heat, of the size of a day's work, acted for some hours, the axes standing or swept, and
 * ended some hours ago. Combinations are weighted by the evidence of the first readings.
 *
 * All long work is a job of slices: tt_past_begin_..., then tt_past_slice until it returns 1. The order at a start:
 * heats; modes of cooling, then of standing and of swept axes; offers of the readings and tt_past_weigh (or
 * tt_past_unmeasured); patterns. */

#include "compensation/control/eigen.h"
#include "compensation/control/sensitivities.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { tt_past_hours = 4, tt_past_idles = 6, tt_past_sizes = 5, tt_past_kinds = 2 * tt_past_hours };
enum { tt_most_starts = 3 }; /* possible initial temperatures that are weighed against each other */
enum { TT_MODES_COOLING, TT_MODES_STILL, TT_MODES_SWEPT };

typedef struct tt_past_model {
  const tt_sensor_model* sensors;
  int32_t heats;
} tt_past_model;

/* Readings at the start, above the uniform temperature `zero_K` of a rested machine, which has this deviation. */
typedef struct tt_first_readings {
  int32_t count;
  const int32_t* sensor; /* (count) among the measured */
  const double* value_K; /* (count) */
  double zero_K, uniform_K;
} tt_first_readings;

typedef struct tt_past {
  const tt_past_model* model;
  double* heats;                     /* (order x heats) W on the basis */
  double *left, *seen;               /* (order, measured x kinds, heats, idles) what is left, and how sensors see it */
  double *cooling, *cooling_decay;   /* (order x order), (order) modes of the machine switched off, 1/s */
  double *modes, *decay;             /* of the machine at work; of the patterns */
  double *eigen_work, *warm, *modal; /* scratch */
  int32_t* eigen_progress;
  double *sizes, *patterns; /* (heats x idles) root mean squares; (order x tt_most_patterns) */
  int32_t* chosen;          /* (measured) sensors of the readings */
  double *values, *rest, *whole, *alone, *spread, *factor; /* of the readings */
  double *offered, *chances; /* (starts x idles, heats + 1, sizes) log evidence; probability */
  int32_t* progress;
} tt_past;

void tt_past_lay(tt_past* w, const tt_past_model* model, tt_arena* arena);
void tt_past_set_heats(tt_past* w, const double* heats); /* (order x heats) */

/* Modes at an operator K0 + sum p K, and what is left by work in them. Cooling comes first. */
void tt_past_begin_modes(tt_past* w, int kind, const double* operator_matrix);
/* Every combination beside the readings. With `predicts` the last reading is judged by the others instead, and `start`
 * (0 .. tt_most_starts - 1) is the place of the result. */
void tt_past_begin_offers(tt_past* w, const tt_first_readings* readings, int predicts, int start);
void tt_past_begin_patterns(tt_past* w);
/* All jobs of a start together take no more. */
int tt_past_slices(const tt_past_model* model);
/* Returns 0: more to do, 1: done, 2: eigenvalues did not converge. */
int tt_past_slice(tt_past* w);
/* At most so many slices at once, to the same bits: modes are read once for them. slices: then as many as it did. */
int tt_past_work(tt_past* w, int* slices);

/* Sizes by the offers. Returns the log probability density of the readings. */
double tt_past_weigh(tt_past* w);
/* Sizes without readings: as much as makes sensors differ by some kelvin. */
void tt_past_unmeasured(tt_past* w);
/* The probability of a reading at least as far from its prediction, over the offers at the first `starts` places. */
double tt_past_chance(const tt_past* w, int starts);
/* After the slices: number of patterns of unit deviation, in w->patterns. */
int tt_past_shapes(const tt_past* w);

#ifdef __cplusplus
}
#endif
#endif
