/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_MODEL_BYTES_H
#define THERMOTWIN_MODEL_BYTES_H
/* A tt_model in one block of bytes, as a file holds it: a head, the name, the counts (int32), the numbers (double), and
 * the arrays and texts in the order of model.h. Each entry is its length (uint64) and its values; texts also have their
 * size in bytes. All start at multiples of 8 bytes, in the byte order of the processor. control_bytes.h writes it. */

#include <stddef.h>

#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TT_MODEL_MAGIC "tt model"
/* Version 2 may have tables over the time of day, version 3 a holding axis with friction. The layout is the same. */
enum { TT_MODEL_FIRST_VERSION = 1, TT_MODEL_VERSION = 3 };

typedef struct tt_model_head {
  char magic[8];
  uint64_t version, hash, bytes, texts; /* bytes: of the whole; texts: pointers that tt_model_read needs */
  uint64_t sum;                         /* tt_model_sum of what follows the head */
} tt_model_head;

uint64_t tt_model_sum(const void* bytes, size_t count);
/* Number of pointers to texts, or -1 where the bytes are no model of these versions. */
long tt_model_texts(const void* bytes, size_t size);
/* Sets m to point into the bytes (aligned to 8) and into texts, which both must outlive it. texts: room for
 * tt_model_texts() pointers. Returns 0, or 1 if the bytes are not a complete model. */
int tt_model_read(const void* bytes, size_t size, const char** texts, tt_model* m);

#ifdef __cplusplus
}
#endif
#endif
