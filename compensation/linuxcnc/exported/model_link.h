/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_MODEL_LINK_H
#define THERMOTWIN_MODEL_LINK_H
/* The model process as thermotwin_pins sees it: rows and answers of model_rows.h over a process_link.h. */

#include "model_rows.h"
#include "process_link.h"

typedef struct model_link {
  process_link link;
  const char *program, *state, *arguments[3];
  size_t filled;      /* bytes of an answer that has not come whole */
  unsigned answering; /* start that they belong to */
  unsigned char part[sizeof(model_answer)];
} model_link;

void model_link_begin(model_link* link, const char* program, const char* state);
void model_link_tend(model_link* link, double now);
/* Sends a row if the model is up and keeps up. now: monotonic time, s. Returns whether it was sent. */
int model_link_send(model_link* link, const model_row* row, double now);
/* Takes the newest answer, for which it waits wait_ms at most. Returns whether there was one. */
int model_link_answer(model_link* link, int wait_ms, double now, model_answer* answer);
/* Lets the process save its state, and waits for its end up to a second. */
void model_link_end(model_link* link);
#endif
