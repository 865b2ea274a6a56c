#!/usr/bin/env bash
# Installs the Debian 12 packages that lumesh needs and that are missing.
#   scripts/packages.sh GROUP...          groups: build, test, browser, checks, solvers, coverage
#   scripts/packages.sh --list GROUP...   prints the names only
# Does nothing, and needs neither network nor root, when everything is there.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

# What compiles and links the program. ITK's libraries are linked one by one, so its CMake package, VTK and Qt
# are not needed; CGAL is used for its header-only kernel of exact predicates.
build_packages=(
  g++ cmake ninja-build
  libinsighttoolkit5-dev             # images: NRRD, GIPL, DICOM
  libcgal-dev libgmp-dev libmpfr-dev # exact predicates
  libeigen3-dev libtbb-dev libfmt-dev nlohmann-json3-dev libpugixml-dev libcli11-dev zlib1g-dev
  libssl-dev libdeflate-dev libpng-dev libhwloc-dev libhdf5-dev
  libnanoflann-dev libtomlplusplus-dev # nearest neighbours, case files
)
# What tests the program and its files: the test framework and the programs that open what lumesh writes.
test_packages=(python3 libgtest-dev gmsh python3-meshio python3-h5py python3-numpy python3-vtk9 util-linux)
# A browser without a display, which opens the report.
browser_packages=(chromium)
# Solvers that run on what lumesh writes, 0.8 GB; their tests skip themselves where they are missing.
solver_packages=(openfoam python3-dolfinx)
# What checks the source, and the second compiler; ccache makes the second build quick.
check_packages=(clang-format-14 clang-tidy clang-14 ccache lld)
# What reads line coverage (scripts/coverage).
coverage_packages=(gcovr)

packages_of() {
  case $1 in
    build) printf '%s\n' "${build_packages[@]}" ;;
    test) printf '%s\n' "${test_packages[@]}" ;;
    browser) printf '%s\n' "${browser_packages[@]}" ;;
    checks) printf '%s\n' "${check_packages[@]}" ;;
    coverage) printf '%s\n' "${coverage_packages[@]}" ;;
    solvers) printf '%s\n' "${solver_packages[@]}" ;;
    *) fail "scripts/packages.sh: no group '$1'; groups: build, test, browser, checks, solvers, coverage" ;;
  esac
}

is_installed() { [[ $(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null) == installed ]]; }

# Network mirrors stall now and then: wait for another apt's lock, and try downloads again.
apt_get() {
  local as_root=()
  if [[ $(id -u) != 0 ]]; then as_root=(sudo); fi
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q \
    -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 -o Dpkg::Use-Pty=0 "$@"
}

install_missing() {
  local missing=()
  for package in "$@"; do is_installed "$package" || missing+=("$package"); done
  if [[ ${#missing[@]} == 0 ]]; then
    say "packages: all $# are installed"
    return
  fi
  if [[ $(id -u) != 0 ]] && ! command -v sudo >/dev/null; then
    fail "these packages are missing and installing them needs root or sudo: ${missing[*]}"
  fi
  say "packages: installing ${#missing[@]} from Debian (${missing[*]}); output in build/logs/packages-*.log"
  logged packages-update apt_get update || fail "apt-get update failed: check the network and /etc/apt/sources.list"
  logged packages-install apt_get install -y --no-install-recommends "${missing[@]}" ||
    fail "apt-get could not install the packages; the log above says which"
}

mode=install
if [[ ${1:-} == --list ]]; then mode=list; shift; fi
[[ $# -gt 0 ]] || fail "usage: scripts/packages.sh [--list] GROUP...; groups: build, test, browser, checks, solvers, coverage"
names=()
for group in "$@"; do mapfile -t -O "${#names[@]}" names < <(packages_of "$group"); done
if [[ $mode == list ]]; then printf '%s\n' "${names[@]}"; exit; fi

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  fail "this is not Debian: install the counterparts of these packages, then build with CMake: ${names[*]}"
fi
install_missing "${names[@]}"
