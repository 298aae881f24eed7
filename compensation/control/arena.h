/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_ARENA_H
#define THERMOTWIN_ARENA_H
/* Memory of the online core: one block that the caller gives, cut into arrays at the start. Without a block the arena
 * only counts, so that the same code says how many bytes it needs. All values of a twin lie in the block and no
 * pointer does; a copy of the block is the saved state. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tt_arena {
  unsigned char* block; /* aligned to 8 bytes; NULL: count only */
  size_t used;          /* bytes */
} tt_arena;

/* Each array starts at a multiple of 8 bytes and is zero. NULL while the arena only counts. */
void* tt_bytes(tt_arena* arena, size_t bytes); /* of structs */
double* tt_doubles(tt_arena* arena, ptrdiff_t count);
float* tt_floats(tt_arena* arena, ptrdiff_t count);
int32_t* tt_ints(tt_arena* arena, ptrdiff_t count);

#ifdef __cplusplus
}
#endif
#endif
