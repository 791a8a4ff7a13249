#!/usr/bin/env bash
# Installs the package in a bare Debian 12 as a user would, and uses it there: test_in_chroot.sh MPM.deb [MIRROR]
# Needs root, debootstrap and a package mirror; if one of them is missing, it ends with code 77 (skipped).
set -euo pipefail
deb=$(realpath "$1")
# shellcheck source=packaging/chroot.sh
. "$(dirname "$(realpath "${BASH_SOURCE[0]}")")/chroot.sh"
make_chroot "${@:2}"
cp "$deb" "$root/srv/mpm.deb"

say "apt install ./mpm.deb"
logged env -C /srv apt-get -qq -y install ./mpm.deb

say "mpm"
inside mpm --version
library_with() { # hidden features of the processor, as GLIBC_TUNABLES names them: the library that the dynamic linker takes
  inside env "GLIBC_TUNABLES=glibc.cpu.hwcaps=$1" LD_DEBUG=libs mpm --version 2>&1 | sed -n 's/.*calling init: \(.*libmpm\.so\).*/\1/p' | tail -n 1
}
native=$(library_with "")
say "library: $native"
best=$(inside /lib64/ld-linux-x86-64.so.2 --help | sed -n 's/^  \(x86-64-v[234]\) (supported.*/\1/p' | head -n 1)
case $best in
  x86-64-v[34]) [[ $native == */glibc-hwcaps/$best/libmpm.so ]] || { say "this processor runs $best, but the library is $native"; exit 1; } ;;
esac

say "a shortened example at each level that this processor runs"
short=(/usr/share/mpm/examples/avalanche_fr3.toml --threads 1 --set numerics.cell_size_m=0.875 --set conveyor.width_m=8.75 --set output.duration_s=1)
inside mpm check "${short[0]}" >/dev/null
inside mpm run "${short[@]}" --out /srv/best >"$root/srv/best.json" 2>/dev/null
inside grep -q '"particles_lost": 0' /srv/best/results.json
instruction_set() { inside sed -n 's/.*"instruction_set": "\(.*\)".*/\1/p' "/srv/$1/results.json"; }
sets=("$(instruction_set best)")
for hidden in -AVX512F -AVX2; do # without these the processor is of a lower level
  case $hidden in -AVX512F) expected=glibc-hwcaps/x86-64-v3/libmpm.so ;; *) expected=mpm/libmpm.so ;; esac
  [[ $best != x86-64-v2 ]] || expected=mpm/libmpm.so
  found=$(library_with "$hidden")
  [[ $found == */$expected ]] || { say "with $hidden the library is $found, not $expected"; exit 1; }
  inside env "GLIBC_TUNABLES=glibc.cpu.hwcaps=$hidden" mpm run "${short[@]}" --out "/srv/run$hidden" >/dev/null 2>&1 || { say "fails with $hidden"; exit 1; }
  sets+=("$(instruction_set "run$hidden")")
done
say "instruction sets: ${sets[*]}"
[ "$best" != x86-64-v4 ] || [ "$(printf '%s\n' "${sets[@]}" | sort -u | wc -l)" -eq 3 ] || { say "these are not three levels"; exit 1; }

say "links of the documentation; commands of its pages beside a copy of the examples"
for folder in doc/mpm mpm; do
  python3 "$(dirname "${BASH_SOURCE[0]}")/../tests/check_docs.py" --links "$root/usr/share/$folder" >&2
done
inside bash -c 'mkdir /srv/work && cd /srv/work && cp -r /usr/share/mpm/examples . && mpm design examples/design/mast.toml --quick --plan' >/dev/null 2>&1 || {
  say "mpm design examples/design/mast.toml does not find its site"
  exit 1
}

say "pictures and Python"
inside mpm post /srv/best >/dev/null 2>&1
inside test -s /srv/best/post/side_view.png
inside python3 -c '
from mpmtools import Case, Run
print(Run("/srv/best").quantity("force_peak_n"))
print(Case.read("/usr/share/mpm/examples/avalanche_fr3.toml").check())'

say "a documented design, shortened: two grids, two seconds"
inside bash -c '{ cat /usr/share/mpm/examples/design/mast.toml; printf "[plan]\nfinest_cells = 5\ngrids = 2\nduration_s = 2.0\n"; } >/srv/mast.toml'
inside mpm design /srv/mast.toml --quick --out /srv/design >"$root/srv/design.log" 2>&1 || {
  tail -n 5 "$root/srv/design.log" >&2
  exit 1
}
inside python3 -c '
import json
page = open("/srv/design/design.html", encoding="utf-8").read()
assert page.count("<figure>") >= 5, "the page has too few figures"
assert json.load(open("/srv/design/design.json"))["format_version"] == 1'

say "man pages, completion, schema, tutorials"
inside test -s /usr/share/man/man1/mpm-run.1.gz || say "man pages are left out of this minimal system, as its dpkg is configured"
inside bash -n /usr/share/bash-completion/completions/mpm
inside python3 -m json.tool /usr/share/mpm/case.schema.json /dev/null
inside env -C /srv python3 /usr/share/mpm/examples/tutorials/a_first_mast.py /srv/tutorial >"$root/srv/tutorial.log" 2>&1 || {
  tail -n 5 "$root/srv/tutorial.log" >&2
  exit 1
}
say "removal leaves nothing"
inside dpkg --purge mpm >/dev/null 2>&1
if inside find /usr -regextype egrep -regex '.*/(mpm|mpmtools)(/.*)?' | grep .; then
  say "these files are left"
  exit 1
fi
say "the package is good"
