/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Drives thermotwin_model as thermotwin_pins does, kills it, and compares with a twin of its own that never stops.
 *   drive PROGRAM STATE kills|cuts COUNT SEED
 * kills: the process is killed at random rows. cuts: everything is killed at once, files are left as a power cut may
 * leave them, and an hour later other pins go on. Prints the RMS of the
 * difference of offsets over that of the offsets (after a cut: over the hour that follows); the largest offset, um; the
 * fastest change of an offset over the set rate; the longest time until an answer, s; and the number of answers. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "model_link.h"
#include "twin.h"

static double state_block[TT_STATE_BYTES / 8 + 1], work_block[TT_WORK_BYTES / 8 + 1];
static tt_twin reference;
static model_link link_to;
static double longest_s, offset_um, fastest, apart_squares, squares;
static double last_um[TT_LINEAR_AXES], last_time = -1.0;
static long answers;

static double now_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double chance(void) { return rand() / (RAND_MAX + 1.0); }

static void fill(model_row* row, double time, int off) {
  const tt_model* m = &tt_the_model;
  memset(row, 0, sizeof *row);
  row->time_s = time;
  for (int k = 0; k < m->channels; ++k) {
    row->channels[k] = m->channel_default[k];
    if (off && m->channel_state[k]) row->channels[k] = 0.0;
    if (off && m->channel_temperature[k]) row->channels[k] = NAN;
    if (!off && strcmp(m->channel_names[k], "spindle.speed_rpm") == 0)
      row->channels[k] = fmod(time, 3000.0) < 2000.0 ? 6000.0 : 0.0;
  }
  if (off && m->machine_on >= 0) row->channels[m->machine_on] = 0.0;
  for (int a = 0; off && a < m->axes; ++a) row->channels[m->axis_position[a]] = NAN;
  for (int s = 0; s < m->sensors; ++s) row->sensors_C[s] = NAN;
}

static void compare(const model_answer* answer, double time, int counted) {
  for (int i = 0; i < TT_LINEAR_AXES; ++i) {
    const double got = answer->offset_um[i], due = reference.offset_um[i];
    if (last_time > 0.0) fastest = fmax(fastest, fabs(got - last_um[i]) / (time - last_time) / tt_the_model.rate_um_s);
    last_um[i] = got;
    offset_um = fmax(offset_um, fabs(due));
    if (!counted) continue;
    apart_squares += (got - due) * (got - due);
    squares += due * due;
  }
  last_time = time;
}

/* One row for both. */
static void row(double time, uint64_t session, int counted) {
  static model_row one;
  model_answer answer;
  const double begun = now_s();
  fill(&one, time, 0);
  one.session = session;
  tt_twin_row(&reference, time, one.channels, NULL);
  while (now_s() - begun < 5.0) {
    model_link_tend(&link_to, now_s());
    if (link_to.link.unanswered == 0) model_link_send(&link_to, &one, now_s());
    if (!model_link_answer(&link_to, 20, now_s(), &answer)) continue;
    ++answers;
    longest_s = fmax(longest_s, now_s() - begun);
    compare(&answer, time, counted);
    return;
  }
  longest_s = 1e9;
}

static void end_process(void) {
  if (link_to.link.process > 0) kill(link_to.link.process, SIGKILL);
}

/* The first `share` of a file's bytes, as if the rest had not reached the disk. */
static void cut_off(const char* state, const char* end, double share) {
  char path[4096];
  FILE* file;
  long bytes;
  snprintf(path, sizeof path, "%s%s", state, end);
  file = fopen(path, "rb");
  if (!file) return;
  fseek(file, 0, SEEK_END);
  bytes = ftell(file);
  fclose(file);
  if (truncate(path, (off_t)(share * (double)bytes))) perror(path);
}

static void leave_as_a_cut_may(const char* state, int how) {
  cut_off(state, ".live", chance());
  cut_off(state, ".new", chance());
  if (how % 3 == 1) cut_off(state, "", chance()); /* the older version has to do */
}

static void kills(int count) {
  const double row_s = 0.5;
  double time = 1e6;
  for (int k = 0; k < count; ++k) {
    const int rows = 1 + (int)(20.0 * chance());
    for (int i = 0; i < rows; ++i) row(time += row_s, 1, 1);
    end_process();
  }
}

static void cuts(const char* state, int count) {
  const double pause = 3600.0, row_s = 5.0;
  double time = 1e6;
  static model_row off;
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < 200 + (int)(20.0 * chance()); ++i) row(time += row_s, (uint64_t)k, 0);
    end_process();
    while (link_to.link.process > 0 && kill(link_to.link.process, 0) == 0) model_link_tend(&link_to, now_s());
    leave_as_a_cut_may(state, k);
    model_link_begin(&link_to, link_to.program, state);
    fill(&off, time, 1);
    for (double at = 1e-3; at < pause - 30.0; at = at < 1.0 ? 60.0 : at + 60.0)
      tt_twin_row(&reference, time + at, off.channels, NULL);
    time += pause;
    last_time = -1.0; /* a control has dropped its offsets meanwhile */
    for (int i = 0; i < 720; ++i) row(time += row_s, (uint64_t)k + 1, 1);
  }
}

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  srand((unsigned)atoi(argv[5]));
  tt_twin_begin(&reference, &tt_the_model, state_block, work_block);
  model_link_begin(&link_to, argv[1], argv[2]);
  if (strcmp(argv[3], "kills") == 0)
    kills(atoi(argv[4]));
  else
    cuts(argv[2], atoi(argv[4]));
  printf("%.6g %.6g %.6g %.6g %ld\n", sqrt(apart_squares / squares), offset_um, fastest, longest_s, answers);
  model_link_end(&link_to);
  return 0;
}
