#!/usr/bin/env bash
# Builds and installs mpm::core in a bare Debian 12 that has a compiler, CMake, Ninja and Eigen and no other library, and uses it there:
# test_core_in_chroot.sh [MIRROR]
# Needs root, debootstrap and a package mirror; if one of them is missing, it ends with code 77 (skipped).
set -euo pipefail
source_dir=$(dirname "$(dirname "$(realpath "${BASH_SOURCE[0]}")")")
# shellcheck source=packaging/chroot.sh
. "$source_dir/packaging/chroot.sh"
make_chroot "$@"

say "apt install: compiler, CMake, Ninja, Eigen"
logged apt-get -qq -y --no-install-recommends install g++ cmake ninja-build libeigen3-dev
for package in libhdf5-dev zlib1g-dev libfmt-dev libtomlplusplus-dev nlohmann-json3-dev libboost-dev; do
  ! inside dpkg-query -W "$package" >/dev/null 2>&1 || { say "$package is installed, so this is no test of the core alone"; exit 1; }
done

say "configure, build and install with MPM_CORE_ONLY"
mkdir "$root/srv/mpm"
# The files that a build of the core and its installation read.
tar -C "$source_dir" -cf - CMakeLists.txt LICENSE README.md cmake examples libmpm python scripts tests/integration/install_core | tar -C "$root/srv/mpm" -xf -
logged cmake -S /srv/mpm -B /srv/build -G Ninja -D MPM_CORE_ONLY=ON
logged cmake --build /srv/build
logged cmake --install /srv/build --prefix /srv/prefix

say "a program with find_package(mpm COMPONENTS core)"
logged cmake -S /srv/mpm/tests/integration/install_core -B /srv/consumer -G Ninja -D CMAKE_BUILD_TYPE=Release -D CMAKE_PREFIX_PATH=/srv/prefix
logged cmake --build /srv/consumer
inside /srv/consumer/install_core
say "the core builds, installs and works with Eigen and OpenMP alone"
