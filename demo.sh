#!/usr/bin/env bash
# Installs, builds, simulates a drive of 64 beams through a town that closes loops, and maps it twice: with the wheels as
# odometry and with our own. Ends with the accuracy before and after, and where map and pictures are.
set -euo pipefail
cd "$(dirname "$0")"
source cmake/install_dependencies.sh
install_packages "${build_packages[@]}"

echo "== building scslam (build/release)"
cmake --preset release >build.log 2>&1 && cmake --build --preset release >>build.log 2>&1 || { tail -n 40 build.log >&2; exit 1; }
rm -f build.log

scslam=build/release/scslam
mkdir -p build/demo
echo "== simulating a minute's drive through a town (scenario s02: a figure of eight, twice)"
$scslam sim s02 -o build/demo/town.rawlog -w
echo
echo "== mapping it with the drifting wheels as odometry: the loops do the work"
$scslam run build/demo/town.rawlog --odometry poses -o build/demo/wheels -w
echo
echo "== mapping it with our own odometry (voxel_icp)"
$scslam run build/demo/town.rawlog -o build/demo/town -w
echo
echo "== exporting the map"
$scslam export build/demo/town --format ply,octomap
echo "pictures of the world and of a scan: build/demo/town.oblique.png, town.world.png, town.scan.png"
