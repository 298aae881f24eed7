/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_MODEL_LINK_H
#define THERMOTWIN_MODEL_LINK_H
/* The model process as thermotwin_pins sees it: started, fed, and started again when it has died or no longer answers.
 * Nothing here waits longer than it is told to. */

#include <sys/types.h>

#include "model_rows.h"

typedef struct model_link {
  const char *program, *state;
  pid_t process; /* 0: none */
  int to, from;
  double begun_at, next_start_at, wait_s; /* monotonic time, s */
  double answered_at, waiting_since;      /* of the last answer; of the first row without one, or the last answer */
  int unanswered;                         /* rows sent without an answer */
  unsigned starts;
  size_t filled; /* bytes of an answer that has not come whole */
  unsigned char part[sizeof(model_answer)];
} model_link;

void model_link_begin(model_link* link, const char* program, const char* state);
/* Starts the process where it has to be, and ends one that hangs. now: monotonic time, s */
void model_link_tend(model_link* link, double now);
/* Sends a row if the model is up and keeps up. now: monotonic time, s. Returns whether it was sent. */
int model_link_send(model_link* link, const model_row* row, double now);
/* Takes the newest answer, for which it waits wait_ms at most. Returns whether there was one. */
int model_link_answer(model_link* link, int wait_ms, double now, model_answer* answer);
/* Lets the process save its state, and waits for its end up to a second. */
void model_link_end(model_link* link);
#endif
