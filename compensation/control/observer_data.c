/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/observer_data.h"

#include <stddef.h>

static void set_sensors(const tt_model* m, tt_sensor_model* s) {
  s->order = m->order;
  s->terms = m->terms;
  s->inputs = m->inputs;
  s->sensors = m->readings;
  s->measured = m->sensors;
  s->quantities = m->quantities;
  s->drives = m->heating;
  s->air = m->air_quantity;
  s->one_kelvin = m->one_kelvin;
  s->sensor_rows = m->sensor_rows;
  s->sensor_std = m->sensor_std;
  s->term_left = m->term_left;
  s->term_right = m->term_right;
  s->term_weight = m->term_weight;
  s->term_first = m->term_first;
  s->term_right_first = m->term_right_first;
  s->input_columns = m->input_columns;
  s->input_term = m->input_term;
  s->quantity_std = m->quantity_std;
  s->quantity_memory = m->quantity_memory;
  s->quantity_ambient = m->quantity_ambient;
  s->quantity_term_first = m->quantity_term_first;
  s->quantity_term = m->quantity_term;
  s->quantity_input_first = m->quantity_input_first;
  s->quantity_input = m->quantity_input;
  s->quantity_warm_first = m->quantity_warm_first;
  s->quantity_warm = m->quantity_warm;
}

static void set_readings(const tt_model* m, tt_reading_model* r) {
  r->low_C = m->plausible_low_C;
  r->high_C = m->plausible_high_C;
  r->reference_C = m->reference_C;
  r->channels = m->channels;
  r->sensors = m->sensors;
  r->ambients = m->own_ambients;
  r->ambient = m->own_ambient;
  r->default_C = m->channel_default;
}

static void set_day(const tt_model* m, tt_day_model* d) {
  d->channels = m->channels;
  d->axes = m->axes;
  d->coolants = m->coolants;
  d->drives = m->day_drives;
  d->warm = m->warm;
  d->machine_on = m->machine_on;
  d->fluid_on = m->fluid_on;
  d->channel_default = m->channel_default;
  d->axis_position = m->axis_position;
  d->axis_low = m->axis_low;
  d->axis_high = m->axis_high;
  d->travel_low = m->day_low;
  d->travel_high = m->day_high;
  d->coolant_on = m->coolant_on;
  d->drive_channel = m->drive_channel;
  d->drive_half_speed = m->drive_half_speed;
  d->warm_quantity = m->warm_quantity;
  d->warm_K = m->warm_K;
  d->coefficients = NULL;
  d->with = NULL;
}

void tt_observer_data_of(const tt_model* m, tt_observer_data* data) {
  tt_observer_model* o = &data->observer;
  set_sensors(m, &data->sensors);
  set_readings(m, &data->readings);
  set_day(m, &data->day);
  data->day.sensors = &data->sensors;
  o->sensors = &data->sensors;
  o->readings = &data->readings;
  o->heats = tt_day_heats(&data->day);
  o->ambients = m->ambients;
  o->air_channel = m->air_channel;
  o->ambient_channel = m->ambient_channel;
  o->sensor_offset = m->sensor_offset;
  o->step_s = m->step_s;
  o->correction_s = m->correction_s;
  o->start_from_sensors = m->start_from_sensors;
}
