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

typedef struct model_answer {
  double time_s; /* of the row */
  double offset_um[TT_LINEAR_AXES], std_um[TT_LINEAR_AXES];
  int32_t status; /* twin.h; TT_REFUSED_TIME: nothing has changed */
  int32_t guard;
} model_answer;
#endif
