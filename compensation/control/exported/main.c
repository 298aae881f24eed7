/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads rows of CSV from stdin and writes the offsets of each to stdout. The first line names the columns: time_s,
 * channels of the machine, and its sensors as NAME_C; others are not read. An empty cell keeps the last value, or says
 * that a sensor has no reading. So does a cell that is no number, which is said on stderr. A row without a time, or
 * with another number of cells than the header, repeats the last offsets with the status input_missing. --bits writes
 * hexadecimal numbers. --state FILE goes on from a saved state, and saves it every minute of the rows' time and at the
 * end: whole in FILE.new, which then takes the place of FILE. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model_data.h"
#include "twin.h"

static const double save_every_s = 60.0;
enum { longest_path = 4096 };
enum { longest_line = 65536, most_columns = 1024, not_read = -2, is_time = -1, first_sensor = TT_CHANNELS };

static double state[TT_STATE_BYTES / 8 + 1], work[TT_WORK_BYTES / 8 + 1];
static unsigned char saved[TT_STATE_BYTES + 64];
static char line[longest_line];
static int column[most_columns];
static char has_column[TT_CHANNELS];
static char has_sensor[TT_SENSORS + 1];
static long line_number = 0;
static double channels[TT_CHANNELS], sensors[TT_SENSORS + 1];

static int channel_of(const char* name) {
  if (strcmp(name, "time_s") == 0) return is_time;
  for (int k = 0; k < tt_the_model.channels; ++k) {
    if (strcmp(name, tt_the_model.channel_names[k]) == 0) return k;
  }
  for (int s = 0; s < TT_SENSORS; ++s) {
    const size_t length = strlen(tt_the_model.sensor_names[s]);
    if (strncmp(name, tt_the_model.sensor_names[s], length) == 0 && strcmp(name + length, "_C") == 0)
      return first_sensor + s;
  }
  return not_read;
}

/* The next cell of the line, which it ends; NULL after the last. */
static char* next_cell(char** rest) {
  char *cell = *rest, *end;
  if (!cell) return NULL;
  end = cell + strcspn(cell, ",\r\n");
  *rest = *end == ',' ? end + 1 : NULL;
  *end = '\0';
  return cell;
}

static int read_line(void) {
  ++line_number;
  return fgets(line, sizeof line, stdin) != NULL;
}

static void say(const char* what, const char* allowed) {
  fprintf(stderr, "stdin:%ld: %s; allowed: %s\n", line_number, what, allowed);
}

/* The number of columns; 0: there is no header, or a column comes twice. */
static int read_header(void) {
  char *rest = line, *cell;
  char has_time = 0;
  int count = 0;
  do {
    if (read_line()) continue;
    say("no header", "a first line of column names");
    return 0;
  } while (line[0] == '#'); /* "# machine NAME HASH", which compensate compares */
  if (strncmp(line, "\xEF\xBB\xBF", 3) == 0) rest += 3; /* byte order mark */
  while ((cell = next_cell(&rest)) != NULL && count < most_columns) {
    const int channel = channel_of(cell);
    char ignored = 0, *had = &ignored; /* of a column that is not read */
    if (channel == is_time) had = &has_time;
    if (channel >= 0) had = channel < first_sensor ? &has_column[channel] : &has_sensor[channel - first_sensor];
    if (*had) {
      say(cell, "each column once");
      return 0;
    }
    *had = 1;
    column[count++] = channel;
  }
  if (has_time) return count;
  say("no column time_s", "time_s among the column names");
  return 0;
}

/* A number and nothing else; NaN with a word on stderr for other text, NaN for a blank cell. */
static double number(const char* cell) {
  char* end;
  const double value = strtod(cell, &end);
  if (end[strspn(end, " \t")] == '\0') return end == cell ? NAN : value;
  say(cell, "a number or a blank cell");
  return NAN;
}

/* The time; NaN: the row does not fit. */
static double read_row(int columns) {
  char *rest = line, *cell;
  double time = NAN;
  int cells = 0;
  /* A channel without a column keeps the value of a machine that stands; a blank cell is a missing value. */
  const double* standing = tt_twin_defaults(&tt_the_model);
  for (int k = 0; k < tt_the_model.channels; ++k) channels[k] = has_column[k] ? NAN : standing[k];
  for (int s = 0; s < TT_SENSORS; ++s) sensors[s] = NAN;
  for (; (cell = next_cell(&rest)) != NULL; ++cells) {
    if (cells >= columns || column[cells] == not_read) continue;
    if (column[cells] == is_time)
      time = number(cell);
    else if (column[cells] >= first_sensor)
      sensors[column[cells] - first_sensor] = number(cell);
    else
      channels[column[cells]] = number(cell);
  }
  if (cells == columns) return time;
  say("another number of cells", "one for each column of the header");
  return NAN;
}

static int load(tt_twin* twin, const char* path) {
  FILE* file = fopen(path, "rb");
  size_t bytes;
  if (!file) return TT_LOADED; /* the first run */
  bytes = fread(saved, 1, sizeof saved, file);
  fclose(file);
  return tt_twin_load(twin, saved, bytes);
}

/* A program that ends in between leaves the file as it was, or the new one whole. */
static int save(const tt_twin* twin, const char* path) {
  static char next[longest_path];
  const size_t bytes = tt_twin_saved_bytes(twin->model);
  FILE* file;
  if (!path) return 0;
  if (strlen(path) + 5 > sizeof next) return 1;
  strcpy(next, path);
  strcat(next, ".new");
  file = fopen(next, "wb");
  if (!file) return 1;
  tt_twin_save(twin, saved);
  const int bad = fwrite(saved, 1, bytes, file) != bytes;
  return fclose(file) != 0 || bad || rename(next, path) != 0;
}

static const char* why_refused(int loaded) {
  static const char* const texts[] = {"", "no state", "a state of another version", "a state of another model",
                                      "a damaged state"};
  return texts[loaded];
}

static void print_header(void) {
  static const char* const kinds[] = {"offset", "std"};
  printf("time_s");
  for (int kind = 0; kind < 1 + tt_the_model.observer; ++kind) {
    for (int i = 0; i < TT_LINEAR_AXES; ++i)
      printf(",%s_%s_um", kinds[kind], tt_the_model.axis_names[tt_the_model.linear_axis[i]]);
  }
  printf(",status\n");
}

/* The failed sensors follow the status: "sensor_failed T3=stuck". */
static void print_row(const tt_twin* twin, double time, int status, const char* format) {
  printf("%.17g", time);
  for (int kind = 0; kind < 1 + tt_the_model.observer; ++kind) {
    for (int i = 0; i < TT_LINEAR_AXES; ++i) {
      printf(",");
      printf(format, kind == 0 ? twin->offset_um[i] : twin->std_um[i]);
    }
  }
  printf(",%s", tt_status_text(status));
  for (int s = 0; s < TT_SENSORS && status == TT_SENSOR_FAILED; ++s) {
    if (tt_twin_sensor_fault(twin, s) != TT_SENSOR_FINE)
      printf(" %s=%s", tt_the_model.sensor_names[s], tt_twin_sensor_fault_text(twin, s));
  }
  printf("\n");
}

int main(int argc, char** argv) {
  const char *path = NULL, *format = "%.6f";
  double saved_at = -HUGE_VAL;
  tt_twin twin;
  for (int i = 1; i < argc; ++i) {
    if (strcmp(argv[i], "--bits") == 0) format = "%a";
    if (strcmp(argv[i], "--state") == 0 && i + 1 < argc) path = argv[++i];
  }
  tt_twin_begin(&twin, &tt_the_model, state, work);
  const int loaded = path ? load(&twin, path) : TT_LOADED;
  if (loaded != TT_LOADED) {
    fprintf(stderr, "%s: %s; allowed: one that this program has saved\n", path, why_refused(loaded));
    return 3;
  }
  const int columns = read_header();
  if (columns == 0) return 3;
  for (int k = 0; k < TT_CHANNELS; ++k) {
    if (!has_column[k] && !isnan(tt_twin_defaults(&tt_the_model)[k])) tt_twin_never_given(&twin, k);
  }
  print_header();
  while (read_line()) {
    const double time = read_row(columns);
    if (isnan(time)) {
      print_row(&twin, twin.now->time, TT_INPUT_MISSING, format);
      continue;
    }
    print_row(&twin, time, tt_twin_row(&twin, time, channels, sensors), format);
    if (path && twin.now->time - saved_at >= save_every_s) {
      saved_at = twin.now->time;
      if (save(&twin, path)) fprintf(stderr, "%s: cannot be written at %g s; goes on\n", path, saved_at);
    }
  }
  if (save(&twin, path)) {
    fprintf(stderr, "%s: cannot be written\n", path);
    return 3;
  }
  return 0;
}
