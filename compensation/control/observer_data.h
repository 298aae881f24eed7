/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_OBSERVER_DATA_H
#define THERMOTWIN_OBSERVER_DATA_H
/* What the parts of the observer need of a model: structs that point into its arrays. */

#include "compensation/control/day_of_work.h"
#include "compensation/control/model.h"
#include "compensation/control/observer.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tt_observer_data {
  tt_sensor_model sensors;
  tt_reading_model readings;
  tt_day_model day; /* without coefficients */
  tt_observer_model observer;
} tt_observer_data;

/* The parts point to each other: data must stay where it is. */
void tt_observer_data_of(const tt_model* m, tt_observer_data* data);

#ifdef __cplusplus
}
#endif
#endif
