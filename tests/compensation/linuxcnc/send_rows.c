/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sends rows to thermotwin_model as thermotwin_pins does.
 *   send_rows PROGRAM STATE SESSION TIME:SPEED:COUNT ...
 * COUNT rows 1 s apart from TIME on, s, with a speed of the spindle in rpm (nan and inf as well). The surroundings are
 * at their defaults. Prints for the last row of each group: status, fault, largest offset in um. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "model_link.h"
#include "twin.h"

static double now_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int answered(model_link* link, const model_row* row, model_answer* answer) {
  const double begun = now_s();
  while (now_s() - begun < 10.0) {
    model_link_tend(link, now_s());
    if (link->link.unanswered == 0) model_link_send(link, row, now_s());
    if (model_link_answer(link, 20, now_s(), answer)) return 1;
  }
  return 0;
}

static void fill(model_row* row, double time, uint64_t session, double speed) {
  const tt_model* m = &tt_the_model;
  memset(row, 0, sizeof *row);
  row->time_s = time;
  row->session = session;
  for (int k = 0; k < m->channels; ++k)
    row->channels[k] = strcmp(m->channel_names[k], "spindle.speed_rpm") == 0 ? speed : m->channel_default[k];
  for (int s = 0; s < m->sensors; ++s) row->sensors_C[s] = NAN;
}

int main(int argc, char** argv) {
  static model_row row;
  model_link link;
  model_answer answer;
  if (argc < 5) return 2;
  model_link_begin(&link, argv[1], argv[2]);
  for (int a = 4; a < argc; ++a) {
    char* end = argv[a];
    const double time = strtod(end, &end), speed = strtod(end + 1, &end);
    const int count = atoi(end + 1);
    double largest = 0.0;
    for (int i = 0; i < count; ++i) {
      fill(&row, time + i, strtoull(argv[3], NULL, 10), speed);
      if (!answered(&link, &row, &answer)) return 1;
    }
    for (int i = 0; i < TT_LINEAR_AXES; ++i) largest = fmax(largest, fabs(answer.offset_um[i]));
    printf("%d %u %.3f\n", answer.status, answer.fault, largest);
  }
  model_link_end(&link);
  return 0;
}
