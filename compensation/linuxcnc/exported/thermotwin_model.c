/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The model beside a control, as a process of its own: rows in on stdin, answers out on stdout (model_rows.h).
 *
 *   thermotwin_model STATE [SECONDS]
 *
 * The state is written whole, by renaming a new file. STATE is flushed to the disk every SECONDS (10) of machine time;
 * the one before stays as STATE.old. STATE.live is written every second and not flushed: it outlives the process,
 * though not a power cut. A start goes on from the latest of them that is whole, else cold. Where the pins are others
 * than before, the power was off: that time is computed with the machine off. Where they are the same, the model alone
 * was gone, and the last row holds. A second process on the same STATE is refused. */
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
static const double live_s = 1.0;

static double state_block[TT_STATE_BYTES / 8 + 1], work_block[TT_WORK_BYTES / 8 + 1];
/* A saved state: session and time of the last row, then the twin's. */
static unsigned char saved[head_words * 8 + TT_STATE_BYTES + 64];
static char new_path[longest_path + 8], old_path[longest_path + 8], live_path[longest_path + 8];
static char lock_path[longest_path + 8];

static void say(const char* what, const char* why) { fprintf(stderr, "thermotwin_model: %s: %s\n", what, why); }

static int read_whole(int from, void* to, size_t bytes) {
  size_t done = 0;
  while (done < bytes) {
    const ssize_t got = read(from, (char*)to + done, bytes - done);
    if (got == 0) return 0;
    if (got > 0) done += (size_t)got;
    if (got < 0 && errno != EINTR) return 0;
  }
  return 1;
}

static int write_whole(int to, const void* from, size_t bytes) {
  size_t done = 0;
  while (done < bytes) {
    const ssize_t put = write(to, (const char*)from + done, bytes - done);
    if (put > 0) done += (size_t)put;
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
  return bytes > 0 ? (size_t)bytes : 0;
}

/* Returns whether the twin goes on from the file, if that is later than `after`. */
static int load(tt_twin* twin, const char* path, double* after, uint64_t* session) {
  static const char* const reasons[] = {"", "no state of a model, or cut off", "of another version", "of another model",
                                        "damaged"};
  const size_t bytes = fetch(path);
  double time = 0.0;
  int why = TT_NO_STATE;
  if (bytes == 0) return 0;
  if (bytes > head_words * 8) {
    memcpy(&time, saved + 8, 8);
    if (time <= *after) return 0;
    why = tt_twin_load(twin, saved + head_words * 8, bytes - head_words * 8);
  }
  if (why != TT_LOADED) {
    say(path, reasons[why]);
    return 0;
  }
  *after = time;
  memcpy(session, saved, 8);
  return 1;
}

static void start_cold(tt_twin* twin) {
  memset(state_block, 0, sizeof state_block);
  tt_twin_begin(twin, twin->model, state_block, work_block);
}

/* The offset to add to the pins' time so that the twin's time rises. */
static double shift_after_start(tt_twin* twin, const model_row* row, int loaded, uint64_t session) {
  const double pause = row->time_s - twin->now->time;
  if (!loaded) return 0.0;
  if (!(pause > 0.0)) {
    say("clock", "is behind the saved state; time goes on from there");
    return twin->now->time - row->time_s + 1.0;
  }
  if (row->session == session) return 0.0;
  if (pause > TT_LONGEST_PAUSE_S) {
    say("state", "is older than 7 days; the start is cold");
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

static int is_locked(const char* path) {
  const int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  return file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0; /* held until the process ends */
}

int main(int argc, char** argv) {
  static model_row row;
  model_answer answer;
  tt_twin twin;
  uint64_t session = 0;
  int loaded, first = 1, failing = 0;
  double every_s = 10.0, shift = 0.0, saved_at = 0.0, live_at = 0.0, latest = -1e300;
  if (argc < 2 || strlen(argv[1]) > longest_path || (argc > 2 && !((every_s = atof(argv[2])) > 0.0))) {
    fprintf(stderr, "usage: thermotwin_model STATE [SECONDS]\n");
    return 2;
  }
  snprintf(new_path, sizeof new_path, "%s.new", argv[1]);
  snprintf(old_path, sizeof old_path, "%s.old", argv[1]);
  snprintf(live_path, sizeof live_path, "%s.live", argv[1]);
  snprintf(lock_path, sizeof lock_path, "%s.lock", argv[1]);
  if (!is_locked(lock_path)) {
    say(lock_path, "another model goes on from this state");
    return 3;
  }
  tt_twin_begin(&twin, &tt_the_model, state_block, work_block);
  loaded = load(&twin, old_path, &latest, &session);
  loaded = load(&twin, argv[1], &latest, &session) || loaded;
  loaded = load(&twin, live_path, &latest, &session) || loaded;
  while (read_whole(STDIN_FILENO, &row, sizeof row)) {
    double time;
    if (first) {
      shift = shift_after_start(&twin, &row, loaded, session);
      saved_at = row.time_s;
      live_at = 0.0;
      first = 0;
    }
    time = row.time_s + shift;
    memset(&answer, 0, sizeof answer);
    answer.time_s = row.time_s;
    answer.status = tt_twin_row(&twin, time, row.channels, row.sensors_C);
    answer.guard = twin.now->guard;
    memcpy(answer.offset_um, twin.offset_um, sizeof answer.offset_um);
    memcpy(answer.std_um, twin.std_um, sizeof answer.std_um);
    if (!write_whole(STDOUT_FILENO, &answer, sizeof answer)) break;
    if (fabs(row.time_s - saved_at) >= every_s) {
      const int good = save(&twin, argv[1], row.session, 1);
      if (!good && !failing) say(argv[1], strerror(errno)); /* said once; the next one is tried */
      failing = !good;
      saved_at = live_at = row.time_s;
    } else if (fabs(row.time_s - live_at) >= live_s) {
      save(&twin, live_path, row.session, 0);
      live_at = row.time_s;
    }
  }
  return !first && !save(&twin, argv[1], row.session, 1) ? 3 : 0;
}
