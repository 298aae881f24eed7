/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/sensor_monitor.h"

#include <math.h>
#include <string.h>

#include "compensation/control/scalars.h"
#include "compensation/control/special.h"

static const double absent_s = 300.0, agreed_s = 1800.0;
static const double window_s = 900.0, window_rows = 8.0; /* that noise is looked for in */
static const double memory_s = 600.0;                    /* of the usual difference; at least four rows */
static const double leap_factor = 12.0, scatter = 4.0, turning = 3.5, moved = 5.0, same = 0.1;
static const double unsure_factor = 3.0; /* deviations of how fast an expected reading changes */
static const double start_K = 1.0, start_factor = 6.0, least_deviation_K = 0.03, model_share = 0.1;
static const double confirm_s = 30.0;              /* that a leap has to stay */
static const double outlast_s = 150.0;             /* the same beside quick rows, behind a jump of an input */
static const double quick_s = 30.0, late_s = 90.0; /* how late the expected reading follows rows that come quicker */
static const double known_readings = 60.0, most_repeats = 0.2, by_chance = 1e-12,
                    lifeless_s = 300.0;     /* of one that scatters */
static const double least_scatter = 0.05;   /* of readings whose repeating says anything, over their deviation */
static const double normal_median = 0.6745; /* of the absolute value of a standard normal number */
static const double root_six = 2.44948974278317809820;
enum { most_count = 1 << 30 };

/* The expectation of a sensor at one row, and its reading beside it. */
typedef struct judged {
  double time, expected;
  double others; /* what sensors differ by from what is expected */
  double unsure_K_s, deviation, reading;
  double interval;   /* s, since the reading before */
  double difference; /* from what is expected and usual */
  double step;       /* of what is expected, since the reading before */
  double unsure, unknown;
  int inputs_leapt;
} judged;

void tt_monitor_lay(tt_monitor* monitor, int sensors, const double* std, tt_arena* arena) {
  monitor->sensors = sensors;
  monitor->std = std;
  monitor->scratch = tt_doubles(arena, sensors);
  monitor->watched = tt_bytes(arena, sensors * sizeof(tt_watched));
}

void tt_monitor_start(tt_monitor* monitor) {
  memset(monitor->watched, 0, monitor->sensors * sizeof(tt_watched));
  for (int s = 0; s < monitor->sensors; ++s) {
    monitor->watched[s].trusted = 1;
    monitor->watched[s].leapt_at = monitor->watched[s].agreed_since = -1.0;
    monitor->watched[s].inputs_leapt_at = -1e18;
  }
}

static tt_recent_sample* sample(tt_watched* w, int i) { return &w->recent[(w->recent_first + i) % tt_recent]; }

void tt_monitor_correct(tt_monitor* monitor, const double* change) {
  for (int s = 0; s < monitor->sensors; ++s) {
    tt_watched* w = &monitor->watched[s];
    if (!w->known) continue;
    w->last_difference -= change[s];
    w->last_expected += change[s];
    w->expected_memory += change[s];
    w->same_learnt += change[s];
    if (!w->from_start) w->usual -= change[s];
    for (int i = 0; i < w->recent_count; ++i) sample(w, i)->difference -= change[s];
  }
}

/* The first reading, or one after a long silence. */
static void arrive(tt_watched* w, const judged* now) {
  const double difference = now->reading - now->expected;
  if (!w->known) {
    w->known = 1;
    w->seen_at = w->same_since = now->time;
    w->last_reading = w->same_value = now->reading;
    w->last_expected = w->same_expected = w->expected_memory = now->expected;
    w->usual = w->last_difference = difference;
    w->same_count = 1;
    /* A sensor far off from the start has nothing usual to leap from. */
    const double off = fabs(difference);
    if (!w->explained && off > start_K && off > start_factor * (now->others + now->deviation)) {
      w->from_start = w->leapt = 1;
      w->usual = 0.0;
      w->leapt_at = now->time;
      w->leap = off;
    }
  } else if (w->fault == TT_SENSOR_ABSENT) {
    w->fault = TT_SENSOR_FINE;
    w->usual = w->last_difference = difference;
    w->last_expected = now->expected;
    w->recent_count = 0;
  }
}

/* Whether the reading stands apart from what was usual before it leapt. */
static int stands_apart(tt_watched* w, const judged* now) {
  const double deviation = now->deviation;
  const double sigma = deviation + model_share * fabs(now->expected - w->expected_memory) +
                       now->unsure_K_s * tt_max(memory_s, 4.0 * now->interval);
  /* An expected reading that jumps alone has followed late. */
  const double jump =
      tt_min(fabs(now->reading - now->expected - w->last_difference), fabs(now->reading - w->last_reading));
  if (!w->leapt && jump > leap_factor * deviation + tt_max(model_share * now->step, now->unknown)) {
    w->leapt = 1;
    w->leapt_at = now->time;
    w->leap = jump;
  }
  const int apart =
      w->leapt && fabs(now->difference) > tt_min(scatter * sigma, tt_max(scatter * deviation, 0.5 * w->leap));
  /* A spike is over at once; what has its name stays until it has agreed for long. */
  if (w->fault != TT_SENSOR_OFFSET && !apart) w->leapt = 0;
  return apart;
}

/* Standard deviation of the reading about a smooth course, from the median of its second differences. */
static double scatter_K(const tt_watched* w) {
  if (w->turn_count == 0) return 0.0;
  return tt_median(w->turn_count, w->turns) / (normal_median * root_six);
}

/* Stuck: the reading repeats while the machine moves on. Coarse digits repeat too. */
static int is_stuck(tt_watched* w, const judged* now) {
  const double digits = fabs(now->reading - w->last_reading);
  if (digits > 0.0) w->smallest_step = w->smallest_step > 0.0 ? tt_min(w->smallest_step, digits) : digits;
  if (fabs(now->reading - w->same_value) <= same * now->deviation) {
    w->same_count += w->same_count < most_count;
  } else {
    if (w->fault != TT_SENSOR_STUCK) {
      w->readings += w->same_count;
      w->repeats += w->same_count - 1;
    }
    w->same_value = now->reading;
    w->same_count = 1;
    w->same_since = now->time;
    w->held = 0;
  }
  if (w->same_count == 1 || (now->interval < quick_s && now->time - w->same_since < late_s)) {
    w->same_expected = now->expected;
    w->same_unsure = w->same_learnt = 0.0;
  }
  w->same_unsure += now->unsure;
  /* What the observer expects follows a stuck sensor for a while; that readings no longer scatter tells sooner.
   * Digits coarser than the scatter repeat too often to say anything. */
  const double chance = (w->repeats + 1.0) / (w->readings + 2.0);
  const int lifeless =
      w->readings >= known_readings && chance <= most_repeats && now->time - w->same_since >= lifeless_s &&
      (w->same_count - 1) * tt_log(chance) <= tt_log(by_chance) && scatter_K(w) > least_scatter * now->deviation;
  const double enough = tt_max(moved * now->deviation, 1.5 * w->smallest_step) + w->same_unsure;
  const double since = now->expected - w->same_expected;
  const int has_moved = tt_min(fabs(since), fabs(since - w->same_learnt)) > enough;
  /* Once stuck, agreeing by chance is no sign of life; another reading is. */
  w->held = w->held || (w->same_count >= 3 && (lifeless || has_moved));
  return w->held;
}

/* Noise turns from reading to reading; what the model gets wrong runs on, so that the second difference has none of it,
 * and what the model does at once is not in the reading. A leap makes two of them large, noise most. */
static int is_noisy(tt_watched* w, const judged* now) {
  const double value = now->reading - now->expected;
  double bend = 0.0;
  if (w->recent_count >= 2) {
    const tt_recent_sample *last = sample(w, w->recent_count - 1), *other = sample(w, w->recent_count - 2);
    bend = tt_min(fabs(value - 2.0 * last->difference + other->difference),
                  fabs(now->reading - 2.0 * last->reading + other->reading));
  }
  const tt_recent_sample present = {now->time, value, now->reading};
  *sample(w, w->recent_count) = present;
  w->far[(w->recent_first + w->recent_count) % tt_recent] =
      bend > turning * root_six * now->deviation + now->unknown + w->last_unknown;
  ++w->recent_count;
  if (!now->inputs_leapt && w->same_count == 1 && w->recent_count > 2) {
    w->turns[w->turn_next] = bend;
    w->turn_next = (w->turn_next + 1) % tt_turns;
    if (w->turn_count < tt_turns) ++w->turn_count;
  }
  w->last_unknown = now->unknown;
  while (w->recent_count == tt_recent ||
         now->time - sample(w, 0)->time > tt_max(window_s, window_rows * now->interval)) {
    w->recent_first = (w->recent_first + 1) % tt_recent;
    --w->recent_count;
  }
  int bends = 0;
  for (int i = 0; i < w->recent_count; ++i) bends += w->far[(w->recent_first + i) % tt_recent];
  return bends >= 3 && 4 * bends >= w->recent_count;
}

static void name_fault(tt_watched* w, const judged* now, int apart, int stuck, int noisy) {
  const double time = now->time;
  /* The expected reading may follow late: what leapt with the inputs waits for it. */
  const int follows = now->interval < quick_s && w->leapt_at - w->inputs_leapt_at <= late_s;
  const int stays = apart && w->leapt_at < time && time - w->leapt_at >= (follows ? outlast_s : confirm_s);
  const int suspect = stuck || noisy || apart;
  if (suspect)
    w->agreed_since = -1.0;
  else if (w->agreed_since < 0.0)
    w->agreed_since = time;
  if (noisy) {
    w->fault = TT_SENSOR_NOISE;
  } else if (stuck) {
    w->fault = TT_SENSOR_STUCK;
  } else if (stays && w->fault == TT_SENSOR_FINE) {
    w->fault = TT_SENSOR_OFFSET;
  } else if (w->fault != TT_SENSOR_FINE && w->agreed_since >= 0.0 && time - w->agreed_since >= agreed_s) {
    w->fault = TT_SENSOR_FINE;
    w->leapt = w->from_start = 0;
  }
  w->trusted = !suspect && w->fault == TT_SENSOR_FINE;
}

static void judge(tt_watched* w, judged* now) {
  now->interval = w->known ? now->time - w->seen_at : 0.0;
  if (now->inputs_leapt) w->inputs_leapt_at = now->time;
  arrive(w, now);
  const double share = -tt_expm1(-now->interval / tt_max(memory_s, 4.0 * now->interval));
  w->expected_memory += share * (now->expected - w->expected_memory);
  /* The reading may have moved as far as expected at once, or not yet at all. */
  now->step = fabs(now->expected - w->last_expected);
  now->unsure = unsure_factor * now->unsure_K_s * now->interval;
  now->unknown = (now->inputs_leapt ? now->step : 0.0) + now->unsure;
  now->difference = now->reading - now->expected - w->usual;
  const int apart = stands_apart(w, now), stuck = is_stuck(w, now), noisy = is_noisy(w, now);
  name_fault(w, now, apart, stuck, noisy);
  if (w->trusted) w->usual += share * now->difference;
  w->seen_at = now->time;
  w->last_reading = now->reading;
  w->last_difference = now->reading - now->expected;
  w->last_expected = now->expected;
}

int tt_monitor_judge(tt_monitor* monitor, double time, const double* reading_K, const double* expected_K,
                     int inputs_leapt, const double* unsure_K_s) {
  /* What sensors differ by from what is expected, at the first readings: most of them are right. */
  int known = 0, changed = 0;
  for (int s = 0; s < monitor->sensors; ++s) {
    if (tt_is_finite(reading_K[s])) monitor->scratch[known++] = fabs(reading_K[s] - expected_K[s]);
  }
  const double usual = known ? tt_median(known, monitor->scratch) : 0.0;
  for (int s = 0; s < monitor->sensors; ++s) {
    tt_watched* w = &monitor->watched[s];
    const int before = w->fault;
    if (tt_is_finite(reading_K[s])) {
      judged now = {time,         expected_K[s], usual, unsure_K_s[s], tt_max(monitor->std[s], least_deviation_K),
                    reading_K[s], 0.0,           0.0,   0.0,           0.0,
                    0.0,          inputs_leapt};
      judge(w, &now);
    } else {
      w->trusted = 0;
      if (w->known && w->fault == TT_SENSOR_FINE && time - w->seen_at > absent_s) w->fault = TT_SENSOR_ABSENT;
    }
    changed = changed || w->fault != before;
  }
  return changed;
}
