/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_MODEL_ROWS_H
#define THERMOTWIN_MODEL_ROWS_H
/* What thermotwin_pins and thermotwin_model, two processes of one computer, say to each other through pipes. */

#include <stdint.h>

#include "model_data.h"

typedef struct model_row {
  double time_s;                /* rising */
  uint64_t session;             /* of the pins: the same as before the model died, or another after the power was off */
  double channels[TT_CHANNELS]; /* NaN: not given */
  double sensors_C[TT_SENSORS + 1]; /* NaN: no reading */
} model_row;

/* Faults of the model process beside the status of a row; bits of model_answer.fault. */
enum {
  MODEL_STATE_REFUSED = 1,   /* a saved state was not used: of another model or version, or none of them is whole */
  MODEL_STATE_UNWRITTEN = 2, /* the last state could not be written */
  MODEL_CLOCK_BACK = 4,      /* the clock was behind the saved state: time goes on from there */
  MODEL_CLOCK_AHEAD = 8      /* the clock was more than 7 days after the saved state: cold start */
};

typedef struct model_answer {
  double time_s; /* of the row */
  double offset_um[TT_LINEAR_AXES], std_um[TT_LINEAR_AXES];
  int32_t status; /* twin.h; TT_REFUSED_TIME: nothing has changed */
  int32_t guard;
  uint32_t fault;
  uint32_t unused;
} model_answer;
#endif
