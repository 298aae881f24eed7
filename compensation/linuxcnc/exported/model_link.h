/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_MODEL_LINK_H
#define THERMOTWIN_MODEL_LINK_H
/* The model process as thermotwin_pins sees it: rows and answers of model_rows.h over a process_link.h. */

#include "model_rows.h"
#include "process_link.h"

typedef struct model_link {
  process_link link;
  const char *program, *state, *arguments[3];
  size_t filled;      /* bytes in part, of an answer that is not complete yet */
  unsigned answering; /* number of the process start (process_link.starts) that these bytes come from */
  unsigned char part[sizeof(model_answer)];
} model_link;

/* program, state: file of the model process and file of its state; both must outlive the link. */
void model_link_begin(model_link* link, const char* program, const char* state);
/* Starts the process where none runs, and ends one that hangs. now: monotonic time, s. */
void model_link_tend(model_link* link, double now);
/* Sends a row if the process runs and not too many rows are without an answer. Returns whether the row was sent. */
int model_link_send(model_link* link, const model_row* row, double now);
/* Takes the newest answer; waits at most wait_ms for the first one. Returns whether there was one. */
int model_link_answer(model_link* link, int wait_ms, double now, model_answer* answer);
/* Lets the process save its state, and waits for its end up to a second. */
void model_link_end(model_link* link);
#endif
