#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Builds the model, the pins and the guard beside this file. With "install" it also puts the guard where LinuxCNC looks
# for real-time components, which needs root.
set -eu
cd "$(dirname "$0")"
core="-std=c99 -O3 -ffp-contract=off"
for file in core/*.c; do
  case $file in core/main.c) ;; *) sources="${sources:-} $file" ;; esac
done
cc $core -Icore -I. thermotwin_model.c $sources -o thermotwin_model -lm
cc $core -Icore -I. -I/usr/include/linuxcnc -DULAPI -Wno-unused-function \
  thermotwin_pins.c model_link.c process_link.c core/model_data.c \
  -o thermotwin_pins -llinuxcnchal -lm
halcompile --compile thermotwin_guard.comp
if [ "${1:-}" = install ]; then halcompile --install thermotwin_guard.comp; fi
