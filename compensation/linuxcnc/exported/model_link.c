/* SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "model_link.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { most_unanswered = 16 };
static const double first_wait_s = 0.02, longest_wait_s = 1.0, start_s = 30.0, hang_s = 2.0;

void model_link_begin(model_link* link, const char* program, const char* state) {
  memset(link, 0, sizeof *link);
  link->program = program;
  link->state = state;
  link->to = link->from = -1;
  link->wait_s = first_wait_s;
  signal(SIGPIPE, SIG_IGN);
}

static int end_of(int* pipe_end) {
  if (*pipe_end >= 0) close(*pipe_end);
  return *pipe_end = -1;
}

static void start(model_link* link, double now) {
  int rows[2], answers[2];
  if (pipe(rows)) return;
  if (pipe(answers)) {
    close(rows[0]);
    close(rows[1]);
    return;
  }
  fcntl(rows[1], F_SETFD, FD_CLOEXEC);
  fcntl(answers[0], F_SETFD, FD_CLOEXEC);
  link->process = fork();
  if (link->process == 0) {
    dup2(rows[0], STDIN_FILENO);
    dup2(answers[1], STDOUT_FILENO);
    close(rows[0]);
    close(answers[1]);
    signal(SIGPIPE, SIG_DFL);
    execl(link->program, link->program, link->state, (char*)NULL);
    fprintf(stderr, "thermotwin_pins: %s: %s\n", link->program, strerror(errno));
    _exit(127);
  }
  close(rows[0]);
  close(answers[1]);
  link->to = rows[1];
  link->from = answers[0];
  fcntl(link->to, F_SETFL, O_NONBLOCK);
  fcntl(link->from, F_SETFL, O_NONBLOCK);
  if (link->process < 0) {
    link->process = 0;
    end_of(&link->to);
    end_of(&link->from);
    return;
  }
  link->begun_at = link->answered_at = now;
  link->unanswered = 0;
  link->filled = 0;
  ++link->starts;
}

void model_link_tend(model_link* link, double now) {
  int how = 0;
  if (link->process > 0) {
    const double patience = link->answered_at > link->begun_at ? hang_s : start_s;
    if (link->unanswered > 0 && now - link->waiting_since > patience) {
      fprintf(stderr, "thermotwin_pins: the model no longer answers and is ended\n");
      kill(link->process, SIGKILL);
    }
    if (waitpid(link->process, &how, WNOHANG) != link->process) return;
    fprintf(stderr, "thermotwin_pins: the model has ended (%s %d) and is started again\n",
            WIFSIGNALED(how) ? "signal" : "status", WIFSIGNALED(how) ? WTERMSIG(how) : WEXITSTATUS(how));
    end_of(&link->to);
    end_of(&link->from);
    link->process = 0;
    /* One that fails at once is not tried again and again without a pause. */
    link->wait_s = link->answered_at > link->begun_at ? first_wait_s : 2.0 * link->wait_s;
    if (link->wait_s > longest_wait_s) link->wait_s = longest_wait_s;
    link->next_start_at = now + link->wait_s;
  }
  if (now >= link->next_start_at) start(link, now);
}

int model_link_send(model_link* link, const model_row* row, double now) {
  ssize_t put;
  if (link->process <= 0 || link->unanswered >= most_unanswered) return 0;
  put = write(link->to, row, sizeof *row);
  if (put != (ssize_t)sizeof *row) {
    /* A row that went out in part cannot be followed by another. */
    if (put > 0) kill(link->process, SIGKILL);
    return 0;
  }
  if (link->unanswered++ == 0) link->waiting_since = now; /* a pause without rows is no silence */
  return 1;
}

int model_link_answer(model_link* link, int wait_ms, double now, model_answer* answer) {
  int got = 0;
  struct pollfd ready;
  if (link->process <= 0 || link->unanswered == 0) return 0;
  ready.fd = link->from;
  ready.events = POLLIN;
  if (poll(&ready, 1, wait_ms) <= 0) return 0;
  for (;;) {
    const ssize_t bytes = read(link->from, link->part + link->filled, sizeof link->part - link->filled);
    if (bytes <= 0) return got;
    link->filled += (size_t)bytes;
    if (link->filled < sizeof link->part) continue;
    memcpy(answer, link->part, sizeof *answer);
    link->filled = 0;
    link->answered_at = link->waiting_since = now;
    if (link->unanswered > 0) --link->unanswered;
    got = 1;
  }
}

void model_link_end(model_link* link) {
  const struct timespec moment = {0, 10000000};
  if (link->process <= 0) return;
  end_of(&link->to);
  for (int i = 0; i < 100; ++i) {
    if (waitpid(link->process, NULL, WNOHANG) == link->process) return;
    nanosleep(&moment, NULL);
  }
  kill(link->process, SIGKILL);
  waitpid(link->process, NULL, 0);
}
