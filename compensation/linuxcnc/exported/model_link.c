/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "model_link.h"

#include <string.h>

void model_link_begin(model_link* link, const char* program, const char* state) {
  memset(link, 0, sizeof *link);
  link->program = link->arguments[0] = program;
  link->state = link->arguments[1] = state;
  process_link_begin(&link->link, "thermotwin_pins", link->arguments);
}

void model_link_tend(model_link* link, double now) { process_link_tend(&link->link, now); }

int model_link_send(model_link* link, const model_row* row, double now) {
  return process_link_send(&link->link, row, sizeof *row, now);
}

int model_link_answer(model_link* link, int wait_ms, double now, model_answer* answer) {
  int got = 0, wait = wait_ms;
  size_t bytes;
  if (link->link.unanswered == 0) return 0;
  if (link->answering != link->link.starts) { /* the rest of an answer of one that has died does not come */
    link->answering = link->link.starts;
    link->filled = 0;
  }
  while ((bytes = process_link_read(&link->link, link->part + link->filled, sizeof link->part - link->filled, wait)) >
         0) {
    wait = 0;
    link->filled += bytes;
    if (link->filled < sizeof link->part) continue;
    memcpy(answer, link->part, sizeof *answer);
    link->filled = 0;
    process_link_answered(&link->link, now);
    got = 1;
  }
  return got;
}

void model_link_end(model_link* link) { process_link_end(&link->link, 1.0); }
