# A bare Debian 12 in a chroot, for the tests beside this file, which source it.
# Needs root, debootstrap and a package mirror; if one of them is missing, skip() says which and ends with code 77.

skip() {
  echo "skipped: $*" >&2
  exit 77
}
say() { printf '== %s\n' "$*" >&2; }

# make_chroot [MIRROR]: sets $root to the folder of the new system, which is removed at the end of the script.
make_chroot() {
  local mirror=${1:-$(grep -rhoE 'https?://[^ ]*/debian/?( |$)' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null | head -n 1 | tr -d ' ' || true)}
  mirror=${mirror:-http://deb.debian.org/debian}
  [ "$(id -u)" -eq 0 ] || skip "this test needs root, to make a chroot"
  command -v debootstrap >/dev/null || skip "debootstrap is not installed"
  root=$(mktemp -d "${TMPDIR:-/tmp}/mpm_chroot.XXXXXX")
  chmod 755 "$root"
  trap remove_chroot EXIT

  say "a bare Debian 12 from $mirror"
  debootstrap --variant=minbase bookworm "$root" "$mirror" >"$root.log" 2>&1 || {
    tail -n 3 "$root.log" >&2
    rm -f "$root.log"
    skip "debootstrap failed; is $mirror within reach?"
  }
  rm -f "$root.log"
  mount -t proc proc "$root/proc" 2>/dev/null || skip "proc cannot be mounted here"
  cp /etc/resolv.conf "$root/etc/" 2>/dev/null || true
  inside apt-get -qq update
}
remove_chroot() {
  ! mountpoint -q "$root/proc" || umount "$root/proc"
  rm -rf --one-file-system "$root"
}

# inside COMMAND...: in the chroot, without this system's environment.
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 "$@"; }

# logged COMMAND...: in the chroot; prints the output only if it fails, and ends the script then.
logged() {
  inside "$@" >"$root/srv/log" 2>&1 || {
    tail -n 20 "$root/srv/log" >&2
    exit 1
  }
}
