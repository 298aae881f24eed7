/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The model beside a control, as a process of its own: rows in on stdin, answers out on stdout (model_rows.h).
 *
 *   thermotwin_model STATE [SECONDS]
 *
 * The state is written whole, by renaming a new file. STATE is flushed to the disk every SECONDS (10) of machine time;
 * the one before stays as STATE.old. STATE.live is written every second and not flushed: it outlives the process,
 * though not a power cut. A start goes on from the latest of them that is whole, else cold. Where the pins are others
 * than before, the power was off: that time is computed with the machine off. Where they are the same, the model alone
 * was gone, and the last row holds. A second process on the same STATE is refused.
 *
 * A state of another model or version is kept as FILE.refused, .refused.1 and so on. Faults (model_rows.h) and changes
 * of the status are lines on stderr, those of the status at most one a minute of machine time. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "model_rows.h"
#include "pause.h"
#include "twin.h"

enum { longest_path = 4000, head_words = 2 };
enum { most_refused = 999, longest_text = 240 };
static const double live_s = 1.0, between_lines_s = 60.0;

static double state_block[TT_STATE_BYTES / 8 + 1], work_block[TT_WORK_BYTES / 8 + 1];
/* A saved state: session and time of the last row, then the twin's. */
static unsigned char saved[head_words * 8 + TT_STATE_BYTES + 64];
static char new_path[longest_path + 8], old_path[longest_path + 8], live_path[longest_path + 8];
static char lock_path[longest_path + 8];

static void say(const char* what, const char* why) { fprintf(stderr, "thermotwin_model: %s: %s\n", what, why); }

static int read_whole(int from, void* to, size_t bytes) {
  char* next = to;
  const char* const end = next + bytes;
  while (next < end) {
    const ssize_t got = read(from, next, end - next);
    if (got == 0) return 0;
    if (got > 0) next += got;
    if (got < 0 && errno != EINTR) return 0;
  }
  return 1;
}

static int write_whole(int to, const void* from, size_t bytes) {
  const char *next = from, *const end = next + bytes;
  while (next < end) {
    const ssize_t put = write(to, next, end - next);
    if (put > 0) next += put;
    if (put <= 0 && errno != EINTR) return 0;
  }
  return 1;
}

/* Writes the state by way of a new file. flush: to the disk */
static int save(const tt_twin* twin, const char* path, uint64_t session, int flush) {
  const size_t bytes = head_words * 8 + tt_twin_saved_bytes(twin->model);
  const int file = open(new_path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  int good;
  if (file < 0) return 0;
  memcpy(saved, &session, 8);
  memcpy(saved + 8, &twin->now->time, 8);
  tt_twin_save(twin, saved + head_words * 8);
  good = write_whole(file, saved, bytes) && (!flush || fsync(file) == 0);
  good = close(file) == 0 && good;
  if (!good) return 0;
  if (flush) rename(path, old_path); /* there may be none yet */
  return rename(new_path, path) == 0;
}

/* The bytes of a file in `saved`; 0: there is none. */
static size_t fetch(const char* path) {
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  ssize_t bytes;
  if (file < 0) return 0;
  bytes = read(file, saved, sizeof saved);
  close(file);
  return bytes > 0 ? bytes : 0;
}

/* Gives a file another name, so that no state is written over it. */
static void keep(const char* path) {
  static char name[longest_path + 32];
  snprintf(name, sizeof name, "%s.refused", path);
  for (int i = 1; i <= most_refused && access(name, F_OK) == 0; ++i)
    snprintf(name, sizeof name, "%s.refused.%d", path, i);
  if (rename(path, name))
    say(path, strerror(errno));
  else
    say(name, "keeps the refused state");
}

/* The time of a saved state; of one that is cut off: that of no state. */
static double time_of(const char* path) {
  double time = -1e300;
  if (fetch(path) > head_words * 8) memcpy(&time, saved + 8, 8);
  return time;
}

/* Returns whether the twin goes on from the file. refused: set to why not */
static int load(tt_twin* twin, const char* path, uint64_t* session, int* refused) {
  static const char* const reasons[] = {"", "no state of a model, or cut off", "of another version", "of another model",
                                        "damaged"};
  const size_t bytes = fetch(path);
  int why = TT_NO_STATE;
  if (bytes == 0) return 0;
  if (bytes > head_words * 8) why = tt_twin_load(twin, saved + head_words * 8, bytes - head_words * 8);
  if (why != TT_LOADED) {
    say(path, reasons[why]);
    if (why == TT_OTHER_MODEL || why == TT_OTHER_VERSION) keep(path);
    *refused = *refused == TT_OTHER_MODEL ? *refused : why;
    return 0;
  }
  memcpy(session, saved, 8);
  return 1;
}

static void start_cold(tt_twin* twin) {
  memset(state_block, 0, sizeof state_block);
  tt_twin_begin(twin, twin->model, state_block, work_block);
}

/* All saved states, the latest one last, so that each of another model is kept. Returns whether one was loaded. */
static int load_latest(tt_twin* twin, const char* path, uint64_t* session, uint32_t* fault) {
  const char* paths[] = {old_path, path, live_path};
  int loaded = 0, refused = TT_LOADED, i, k;
  for (i = 0; i < 3; ++i) {
    for (k = i + 1; k < 3; ++k) {
      const char* const other = paths[k];
      if (!(time_of(other) < time_of(paths[i]))) continue;
      paths[k] = paths[i];
      paths[i] = other;
    }
    loaded = load(twin, paths[i], session, &refused) || loaded;
  }
  /* One that a power cut has damaged is no loss where an older one is whole. */
  if (refused == TT_OTHER_MODEL || refused == TT_OTHER_VERSION || (refused && !loaded)) *fault |= MODEL_STATE_REFUSED;
  return loaded;
}

/* The offset to add to the pins' time so that the twin's time rises. */
static double shift_after_start(tt_twin* twin, const model_row* row, int loaded, uint64_t session, uint32_t* fault) {
  const double pause = row->time_s - twin->now->time;
  if (!loaded) return 0.0;
  if (!(pause > 0.0)) {
    say("clock", "is behind the saved state; time goes on from there");
    *fault |= MODEL_CLOCK_BACK;
    return twin->now->time - row->time_s + 1.0;
  }
  if (row->session == session) return 0.0;
  if (pause > TT_LONGEST_PAUSE_S) {
    say("clock", "is more than 7 days after the saved state; the start is cold");
    *fault |= MODEL_CLOCK_AHEAD;
    start_cold(twin);
    return 0.0;
  }
  tt_twin_pass_pause(twin, row->time_s);
  if (tt_twin_contradicts_pause(twin, row->sensors_C)) {
    say("state", "the readings contradict a machine that was off; starts anew from the readings");
    start_cold(twin);
  }
  return 0.0;
}

static void add_word(char* text, const char* name, const char* why) {
  const size_t used = strlen(text);
  if (used < longest_text) snprintf(text + used, longest_text - used, " %s=%s", name, why);
}

/* A line for a row that is refused, at most ten. */
static void tell_refused(const model_row* row) {
  static int lines;
  if (lines++ >= 10) return;
  fprintf(stderr, "thermotwin_model: row at %.3f s: time does not rise, or leaps by more than 30 days; not used\n",
          row->time_s);
}

/* A line for a status that is not that of the line before. */
static void tell_status(const tt_twin* twin, int status) {
  static int told = TT_OK;
  static double told_at = -1e300;
  char text[longest_text] = "";
  const tt_model* m = twin->model;
  const double time = twin->now->time;
  int i;
  if (status == told || time - told_at < between_lines_s) return;
  told = status;
  told_at = time;
  for (i = 0; status == TT_INPUT_MISSING && i < m->channels; ++i) {
    const int silent = !isnan(m->channel_default[i]) && time - twin->given_at[i] > m->correction_s;
    if (twin->fault[i] != TT_FAULT_NONE)
      add_word(text, m->channel_names[i], tt_fault_text(twin->fault[i]));
    else if (silent && !twin->untold[i])
      add_word(text, m->channel_names[i], "missing");
  }
  for (i = 0; status == TT_SENSOR_FAILED && i < m->sensors; ++i) {
    if (tt_twin_sensor_fault(twin, i)) add_word(text, m->sensor_names[i], tt_twin_sensor_fault_text(twin, i));
  }
  fprintf(stderr, "thermotwin_model: status %s%s\n", tt_status_text(status), text);
}

static int is_locked(const char* path) {
  const int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  return file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0; /* held until the process ends */
}

static int is_bad_call(int argc, char** argv, double* every_s) {
  return argc < 2 || strlen(argv[1]) > longest_path || (argc > 2 && !((*every_s = atof(argv[2])) > 0.0));
}

static void name_files(const char* state) {
  snprintf(new_path, sizeof new_path, "%s.new", state);
  snprintf(old_path, sizeof old_path, "%s.old", state);
  snprintf(live_path, sizeof live_path, "%s.live", state);
  snprintf(lock_path, sizeof lock_path, "%s.lock", state);
}

/* save(), with a line when it begins to fail. The next one is tried; one that is flushed ends the fault. */
static void save_or_say(const tt_twin* twin, const char* path, uint64_t session, int flush, uint32_t* fault) {
  if (save(twin, path, session, flush)) {
    if (flush) *fault &= ~MODEL_STATE_UNWRITTEN;
    return;
  }
  if (!(*fault & MODEL_STATE_UNWRITTEN)) say(path, strerror(errno));
  *fault |= MODEL_STATE_UNWRITTEN;
}

static int answer_row(tt_twin* twin, const model_row* row, double shift, uint32_t fault) {
  model_answer answer;
  memset(&answer, 0, sizeof answer);
  answer.time_s = row->time_s;
  answer.status = tt_twin_row(twin, row->time_s + shift, row->channels, row->sensors_C);
  answer.guard = twin->now->guard;
  answer.fault = fault;
  memcpy(answer.offset_um, twin->offset_um, sizeof answer.offset_um);
  memcpy(answer.std_um, twin->std_um, sizeof answer.std_um);
  if (answer.status == TT_REFUSED_TIME)
    tell_refused(row);
  else
    tell_status(twin, answer.status);
  return write_whole(STDOUT_FILENO, &answer, sizeof answer);
}

int main(int argc, char** argv) {
  static model_row row;
  tt_twin twin;
  uint64_t session = 0;
  uint32_t fault = 0;
  int loaded, first = 1;
  double every_s = 10.0, shift = 0.0, saved_at = 0.0, live_at = 0.0;
  if (is_bad_call(argc, argv, &every_s)) {
    fprintf(stderr, "usage: thermotwin_model STATE [SECONDS]\n");
    return 2;
  }
  name_files(argv[1]);
  if (!is_locked(lock_path)) {
    say(lock_path, "another model goes on from this state");
    return 3;
  }
  tt_twin_begin(&twin, &tt_the_model, state_block, work_block);
  loaded = load_latest(&twin, argv[1], &session, &fault);
  while (read_whole(STDIN_FILENO, &row, sizeof row)) {
    if (first) {
      shift = shift_after_start(&twin, &row, loaded, session, &fault);
      saved_at = row.time_s;
      live_at = 0.0;
      first = 0;
    }
    if (!answer_row(&twin, &row, shift, fault)) break;
    if (fabs(row.time_s - saved_at) >= every_s) {
      save_or_say(&twin, argv[1], row.session, 1, &fault);
      saved_at = live_at = row.time_s;
    } else if (fabs(row.time_s - live_at) >= live_s) {
      save_or_say(&twin, live_path, row.session, 0, &fault);
      live_at = row.time_s;
    }
  }
  return !first && !save(&twin, argv[1], row.session, 1) ? 3 : 0;
}
