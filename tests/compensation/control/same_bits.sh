#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# usage: same_bits.sh SOURCE_DIR FILE.c ...
# Compiles the files by every compiler that is there, and compares what the programs print.
set -euo pipefail
source=$1
shift
files=("$@")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
first= compared=0
try() { # NAME RUNNER COMPILER [OPTION ...]
  local name=$1 runner=$2 said
  shift 2
  if ! command -v "$1" >/dev/null || { [[ -n $runner ]] && ! command -v "$runner" >/dev/null; }; then
    echo "$name: not there"
    return 0
  fi
  "$@" -std=c99 -ffp-contract=off -w -I "$source" "${files[@]}" -o "$folder/program" -lm
  said=$($runner "$folder/program")
  echo "$name: $said"
  compared=$((compared + 1))
  [[ -z $first ]] && first=$said
  [[ $said == "$first" ]] || { echo "other bits than with the first compiler" >&2; exit 1; }
}
try 'gcc -O3' '' gcc -O3
try 'gcc -O0' '' gcc -O0
! grep -qw avx2 /proc/cpuinfo || try 'gcc -O3 -march=x86-64-v3' '' gcc -O3 -march=x86-64-v3
try 'clang -O2' '' clang -O2
try 'aarch64' qemu-aarch64 aarch64-linux-gnu-gcc -O3 -static
[[ $compared -ge 2 ]] || { echo "no two compilers" >&2; exit 1; }
