/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_MODEL_BYTES_H
#define THERMOTWIN_MODEL_BYTES_H
/* A tt_model in one block of bytes, as a file holds it: a head, then counts (int32), numbers (double) and each array as
 * its length (uint64) and its values, all from multiples of 8 bytes, in the order of model.h and the byte order of the
 * processor. control_bytes.h writes it. */

#include <stddef.h>

#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TT_MODEL_MAGIC "tt model"
/* 2: tables over the time of day; a model of version 1 has none and is read as it is. */
enum { TT_MODEL_FIRST_VERSION = 1, TT_MODEL_VERSION = 2 };

typedef struct tt_model_head {
  char magic[8];
  uint64_t version, hash, bytes, texts; /* bytes: of the whole; texts: pointers that tt_model_read needs */
  uint64_t sum;                         /* tt_model_sum of what follows the head */
} tt_model_head;

uint64_t tt_model_sum(const void* bytes, size_t count);
/* Number of pointers to texts, or -1 where the bytes are no model of these versions. */
long tt_model_texts(const void* bytes, size_t size);
/* Sets a model that points into the bytes (aligned to 8), which must outlive it. texts: that many pointers.
 * Returns 0, or 1 where the bytes are no whole model. */
int tt_model_read(const void* bytes, size_t size, const char** texts, tt_model* m);

#ifdef __cplusplus
}
#endif
#endif
