/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_OBSERVER_DATA_H
#define THERMOTWIN_OBSERVER_DATA_H
/* Data of a model for the parts of the observer: structs that point into the model's arrays. */

#include "compensation/control/day_of_work.h"
#include "compensation/control/model.h"
#include "compensation/control/observer.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tt_observer_data {
  tt_sensor_model sensors;
  tt_reading_model readings;
  tt_day_model day; /* coefficients and with are NULL; the caller sets them */
  tt_observer_model observer;
} tt_observer_data;

/* Sets data. Its members point to each other and into m: neither may be moved while data is in use. */
void tt_observer_data_of(const tt_model* m, tt_observer_data* data);

#ifdef __cplusplus
}
#endif
#endif
