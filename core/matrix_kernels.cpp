// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/matrix_kernels.h"

#define THERMOTWIN_COMPILED(...) template __VA_ARGS__;
THERMOTWIN_EACH_KERNEL(THERMOTWIN_COMPILED)
