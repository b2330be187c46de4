#!/usr/bin/env bash
# Installs, builds, runs all tests: ./test.sh            (what CI runs: without half of the simulated scenarios)
#                                   ./test.sh everything (with all of them)
#                                   ./test.sh fast       (only the fast ones, no sanitizers)
set -euo pipefail
cd "$(dirname "$0")"
source cmake/install_dependencies.sh
install_packages "${build_packages[@]}" "${test_packages[@]}"
jobs=$(nproc)

echo "== formatting"
git ls-files '*.h' '*.cpp' 2>/dev/null | xargs -r clang-format --dry-run -Werror

build() {  # preset: quiet unless it fails
  echo "== building: $1"
  cmake --preset "$1" >"build-$1.log" 2>&1 && cmake --build --preset "$1" -j "$jobs" >>"build-$1.log" 2>&1 \
    || { tail -n 60 "build-$1.log" >&2; exit 1; }
  rm -f "build-$1.log"
}

build ci
if [ "${1:-all}" = fast ]; then
  ctest --preset ci -L fast -j "$jobs"
  exit 0
fi

build asan-ubsan
echo "== what reads files and keeps sessions, under the address and undefined-behaviour sanitizers"
# MRPT, GDAL and glog keep memory until the process ends: leaks of theirs are not ours to report.
ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1 ctest --preset asan-ubsan -j "$jobs"

if [ "${1:-all}" = everything ]; then
  echo "== all tests"
  ctest --preset ci -j "$jobs"
else
  echo "== all tests but the scenarios labelled long (./test.sh everything runs them, too)"
  ctest --preset ci -LE long -j "$jobs"
fi
