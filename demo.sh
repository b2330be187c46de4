#!/usr/bin/env bash
# Installs, builds, and maps the real drive with one loop that Debian's mrpt-common ships. Ends with where map and pictures are.
set -euo pipefail
cd "$(dirname "$0")"
source cmake/install_dependencies.sh
install_packages "${build_packages[@]}" "${demo_packages[@]}"

echo "== building scslam (build/release)"
cmake --preset release >build.log 2>&1 && cmake --build --preset release >>build.log 2>&1 || { tail -n 40 build.log >&2; exit 1; }
rm -f build.log

log="/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"
out=build/demo
echo "== mapping a real 2-D laser drive with one loop (MRPT, University of Malaga)"
build/release/scslam run "$log" -o "$out" -w
echo
echo "== exporting the map"
build/release/scslam export "$out" --format ply,octomap
