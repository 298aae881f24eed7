/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_PROCESS_LINK_H
#define THERMOTWIN_PROCESS_LINK_H
/* A process that answers rows through pipes, as its owner sees it: started, fed, and started again when it has died or
 * no longer answers. Nothing here waits longer than it is told to. */

#include <stddef.h>
#include <sys/types.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct process_link {
  const char* owner;                      /* in messages on stderr */
  const char* const* arguments;           /* the program first, NULL after the last */
  pid_t process;                          /* 0: none */
  int to, from;                           /* -1: none */
  double begun_at, next_start_at, wait_s; /* monotonic time, s */
  double answered_at, waiting_since;      /* of the last answer; of the first row without one, or the last answer */
  double hang_s;                          /* one that has not answered for so long is ended; 2 at first */
  int unanswered;                         /* rows sent without an answer */
  int is_killed;                          /* for not answering; its end has not been seen yet */
  unsigned starts;
  int last_status; /* with which the last one exited; -1: a signal ended it, or none has ended */
} process_link;

/* owner and arguments must outlive the link. */
void process_link_begin(process_link* link, const char* owner, const char* const* arguments);
/* Starts the process where it has to be, and ends one that hangs. now: monotonic time, s */
void process_link_tend(process_link* link, double now);
/* Sends a row if the process is up and keeps up. Returns whether it was sent. */
int process_link_send(process_link* link, const void* row, size_t bytes, double now);
/* Reads what has come, waiting wait_ms at most for the first byte; 0: nothing. */
size_t process_link_read(process_link* link, void* to, size_t room, int wait_ms);
/* States that a row was answered. */
void process_link_answered(process_link* link, double now);
/* Closes its input and waits for its end up to wait_s, then kills it. */
void process_link_end(process_link* link, double wait_s);

#ifdef __cplusplus
}
#endif
#endif
