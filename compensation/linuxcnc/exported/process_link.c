/* SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "process_link.h"

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
static const double first_wait_s = 0.02, longest_wait_s = 1.0, start_s = 30.0, first_hang_s = 2.0;

void process_link_begin(process_link* link, const char* owner, const char* const* arguments) {
  memset(link, 0, sizeof *link);
  link->owner = owner;
  link->arguments = arguments;
  link->to = link->from = -1;
  link->wait_s = first_wait_s;
  link->hang_s = first_hang_s;
  link->last_status = -1;
  signal(SIGPIPE, SIG_IGN);
}

static int end_of(int* pipe_end) {
  if (*pipe_end >= 0) close(*pipe_end);
  return *pipe_end = -1;
}

static void run_child(const process_link* link, const int rows[2], const int answers[2]) {
  dup2(rows[0], STDIN_FILENO);
  dup2(answers[1], STDOUT_FILENO);
  close(rows[0]);
  close(answers[1]);
  signal(SIGPIPE, SIG_DFL);
  execv(link->arguments[0], (char* const*)link->arguments);
  fprintf(stderr, "%s: %s: %s\n", link->owner, link->arguments[0], strerror(errno));
  _exit(127);
}

static void start(process_link* link, double now) {
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
  if (link->process == 0) run_child(link, rows, answers);
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
  link->is_killed = 0;
  ++link->starts;
}

void process_link_tend(process_link* link, double now) {
  int how = 0;
  if (link->process > 0) {
    const double patience = link->answered_at > link->begun_at ? link->hang_s : start_s;
    if (link->unanswered > 0 && now - link->waiting_since > patience) {
      if (!link->is_killed) fprintf(stderr, "%s: the model no longer answers and is ended\n", link->owner);
      link->is_killed = 1;
      kill(link->process, SIGKILL);
    }
    if (waitpid(link->process, &how, WNOHANG) != link->process) return;
    fprintf(stderr, "%s: the model has ended (%s %d) and is started again\n", link->owner,
            WIFSIGNALED(how) ? "signal" : "status", WIFSIGNALED(how) ? WTERMSIG(how) : WEXITSTATUS(how));
    link->last_status = WIFEXITED(how) ? WEXITSTATUS(how) : -1;
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

int process_link_send(process_link* link, const void* row, size_t bytes, double now) {
  const ssize_t whole = bytes;
  ssize_t put;
  if (link->process <= 0 || link->unanswered >= most_unanswered) return 0;
  put = write(link->to, row, bytes);
  if (put != whole) {
    /* A row that went out in part cannot be followed by another. */
    if (put > 0) kill(link->process, SIGKILL);
    return 0;
  }
  if (link->unanswered++ == 0) link->waiting_since = now; /* a pause without rows is no silence */
  return 1;
}

size_t process_link_read(process_link* link, void* to, size_t room, int wait_ms) {
  struct pollfd ready;
  ssize_t bytes;
  if (link->process <= 0) return 0;
  ready.fd = link->from;
  ready.events = POLLIN;
  if (wait_ms > 0 && poll(&ready, 1, wait_ms) <= 0) return 0;
  bytes = read(link->from, to, room);
  return bytes > 0 ? bytes : 0;
}

void process_link_answered(process_link* link, double now) {
  link->answered_at = link->waiting_since = now;
  if (link->unanswered > 0) --link->unanswered;
}

void process_link_end(process_link* link, double wait_s) {
  const struct timespec moment = {0, 10000000};
  if (link->process <= 0) return;
  end_of(&link->to);
  for (int i = 0; i < (int)(wait_s * 100.0); ++i) {
    if (waitpid(link->process, NULL, WNOHANG) == link->process) {
      end_of(&link->from);
      link->process = 0;
      return;
    }
    nanosleep(&moment, NULL);
  }
  kill(link->process, SIGKILL);
  waitpid(link->process, NULL, 0);
  end_of(&link->from);
  link->process = 0;
}
