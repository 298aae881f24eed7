/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_LAWS_H
#define THERMOTWIN_LAWS_H
/* Films in air and losses of drives, as solver/operation/film_laws.h and loss_laws.h state them with their sources.
 *
 * Numbers of a loss by its kind (tt_model.loss_numbers):
 *   TT_BEARING  viscosity mm^2/s, torque without load over (nu n)^(2/3) in N mm, torque of the load N mm, count
 *   TT_GUIDE    coulomb N, viscous N s/m
 *   TT_SCREW    force N
 *   TT_MOTOR    torque constant N m/A, copper W/A^2, hysteresis W, eddy W, nominal speed in turns a second
 *   TT_HOLDING  balanced angle rad, full power W, linear share, friction over the largest moment, its arcsine, channel
 *               of the share of the time after a motion in positive direction (where there is friction) */

#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Linear between the points, constant beyond them; 1 for curve -1. */
double tt_curve(const tt_model* m, int curve, double x);

/* W/(m^2 K); length m, delta K, air_K absolute */
double tt_free_convection(int orientation, double length, double delta, double air_K);
double tt_rotating_disc(double speed, double radius); /* rad/s, m */
double tt_radiation_between(double emissivity, double temperature_K, double surroundings_K);

/* Factor on a law of speeds: 1 at half of the largest speed and at rest. */
double tt_by_speed(double relative, double exponent);
/* W of one loss at a row of channels */
double tt_loss_power(const tt_model* m, int loss, const double* row);
double tt_loss_relative_speed(const tt_model* m, int loss, const double* row);

#ifdef __cplusplus
}
#endif
#endif
