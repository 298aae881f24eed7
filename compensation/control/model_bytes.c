/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/model_bytes.h"

#include <string.h>

/* Whole words: 15 MB in some ms. */
uint64_t tt_model_sum(const void* bytes, size_t count) {
  const unsigned char* from = bytes;
  uint64_t sum = UINT64_C(0xCBF29CE484222325), word;
  for (size_t i = 0; i + 8 <= count; i += 8) {
    memcpy(&word, from + i, 8);
    sum = (sum ^ word) * UINT64_C(0x100000001B3);
    sum ^= sum >> 29;
  }
  return sum;
}

static int read_head(const void* bytes, size_t size, tt_model_head* head) {
  if (size < sizeof *head) return 1;
  memcpy(head, bytes, sizeof *head);
  return memcmp(head->magic, TT_MODEL_MAGIC, sizeof head->magic) != 0 || head->version < TT_MODEL_FIRST_VERSION ||
         head->version > TT_MODEL_VERSION || head->bytes != size;
}

long tt_model_texts(const void* bytes, size_t size) {
  tt_model_head head;
  if (read_head(bytes, size, &head)) return -1;
  return head.texts;
}

typedef struct reader {
  const unsigned char* at;
  uint64_t left; /* bytes behind it */
  int bad;
} reader;

/* The next values; NULL and bad where the bytes end before. */
static const void* take(reader* r, uint64_t bytes) {
  const unsigned char* here = r->at;
  const uint64_t whole = (bytes + 7u) / 8u * 8u;
  if (r->bad || whole < bytes || whole > r->left) {
    r->bad = 1;
    return NULL;
  }
  r->at += whole;
  r->left -= whole;
  return here;
}

static uint64_t count_of(reader* r) {
  uint64_t count = 0;
  const void* from = take(r, sizeof count);
  if (from) memcpy(&count, from, sizeof count);
  if (count > UINT64_C(0x10000000)) r->bad = 1;
  return count;
}

static const void* array(reader* r, size_t each) { return take(r, count_of(r) * each); }

static const char* const* texts_of(reader* r, const char*** next) {
  const char** first = *next;
  const uint64_t count = count_of(r), bytes = count_of(r);
  const char* text = take(r, bytes);
  for (uint64_t i = 0; i < count && !r->bad; ++i) {
    *(*next)++ = text;
    text += strlen(text) + 1;
  }
  return first;
}

int tt_model_read(const void* bytes, size_t size, const char** texts, tt_model* m) {
  const unsigned char* start = bytes;
  tt_model_head head;
  reader r;
  if (read_head(bytes, size, &head)) return 1;
  if (tt_model_sum(start + sizeof head, size - sizeof head) != head.sum) return 1;
  r.at = start + sizeof head;
  r.left = size - sizeof head;
  r.bad = 0;
  m->hash = head.hash;
  m->name = *texts_of(&r, &texts);
  {
    const int32_t* from = array(&r, sizeof(int32_t));
    if (!from) return 1;
#define TT_FIELD(x) m->x = *from++;
    TT_MODEL_COUNTS(TT_FIELD)
#undef TT_FIELD
  }
  {
    const double* from = array(&r, sizeof(double));
    if (!from) return 1;
#define TT_FIELD(x) m->x = *from++;
    TT_MODEL_NUMBERS(TT_FIELD)
#undef TT_FIELD
  }
#define TT_FIELD(x) m->x = array(&r, sizeof(double));
  TT_MODEL_DOUBLES(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) m->x = array(&r, sizeof(int32_t));
  TT_MODEL_INTS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) m->x = texts_of(&r, &texts);
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
  return r.bad;
}
