#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# usage: same_bits.sh gcc|clang|aarch64 SOURCE_DIR FILE.c ...
# Compiles the files by gcc -O0 and by that compiler, and compares what the programs print. Status 77 where a program is
# missing; with THERMOTWIN_COMPILERS set, 1.
set -euo pipefail
with=$1 source=$2
shift 2
files=("$@")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
need() {
  command -v "$1" >/dev/null && return
  echo "no $1" >&2
  [[ -z ${THERMOTWIN_COMPILERS:-} ]] || exit 1
  exit 77
}
first=
try() { # NAME RUNNER COMPILER [OPTION ...]
  local name=$1 runner=$2 said
  shift 2
  "$@" -std=c99 -ffp-contract=off -w -I "$source" "${files[@]}" -o "$folder/program" -lm
  said=$($runner "$folder/program")
  echo "$name: $said"
  [[ -z $first ]] && first=$said
  [[ $said == "$first" ]] || { echo "other bits than with the first compiler" >&2; exit 1; }
}
try 'gcc -O0' '' gcc -O0
case $with in
  gcc)
    try 'gcc -O3' '' gcc -O3
    ! grep -qw avx2 /proc/cpuinfo || try 'gcc -O3 -march=x86-64-v3' '' gcc -O3 -march=x86-64-v3
    ;;
  clang)
    need clang
    try 'clang -O2' '' clang -O2
    ;;
  aarch64)
    need aarch64-linux-gnu-gcc
    need qemu-aarch64
    try 'aarch64' qemu-aarch64 aarch64-linux-gnu-gcc -O3 -static
    ;;
esac
