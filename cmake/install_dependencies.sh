#!/usr/bin/env bash
# Installs what scslam needs from Debian 12 (or says what is missing when it may not). Sourced by demo.sh and test.sh.
set -euo pipefail

build_packages=(g++ cmake ninja-build ccache lld libeigen3-dev libfmt-dev libyaml-cpp-dev nlohmann-json3-dev libcli11-dev zlib1g-dev
  libpng-dev libceres-dev libembree-dev libassimp-dev libssl-dev liboctomap-dev libgeographiclib-dev libmrpt-maps-dev libmrpt-graphs-dev)
test_packages=(libgtest-dev libgmock-dev libbenchmark-dev mrpt-common clang-format python3)

install_packages() {
  local missing=()
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  echo "== installing ${#missing[@]} Debian packages: ${missing[*]}"
  local sudo=""
  [ "$(id -u)" -eq 0 ] || sudo="sudo"
  if [ -n "$sudo" ] && ! command -v sudo >/dev/null; then
    echo "error: please install as root: apt-get install ${missing[*]}" >&2
    exit 2
  fi
  $sudo apt-get update -qq
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}
