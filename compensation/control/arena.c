/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/arena.h"

#include <string.h>

void* tt_bytes(tt_arena* arena, size_t bytes) {
  const size_t whole = (bytes + 7u) / 8u * 8u;
  unsigned char* start = arena->block ? arena->block + arena->used : NULL;
  if (start) memset(start, 0, whole);
  arena->used += whole;
  return start;
}

double* tt_doubles(tt_arena* arena, ptrdiff_t count) { return tt_bytes(arena, count * sizeof(double)); }
float* tt_floats(tt_arena* arena, ptrdiff_t count) { return tt_bytes(arena, count * sizeof(float)); }
int32_t* tt_ints(tt_arena* arena, ptrdiff_t count) { return tt_bytes(arena, count * sizeof(int32_t)); }
