#!/bin/sh
# Runs a test program on real CAN sockets inside a user-mode Linux, for machines whose own kernel has no CAN: tests/vcan.rs,
# or the one it is given.
#
# Needs, on Debian: user-mode-linux, can-utils, kmod, iproute2. Needs no privileges outside: the guest is a process,
# and its root directory is this machine's own, seen with the rights of whoever starts it.
#
#   fieldbus/io/tests/vcan_uml.sh            builds the test and boots the guest
#   fieldbus/io/tests/vcan_uml.sh BINARY     runs that test binary inside
#
# The guest starts this same script as its init. Exits with the test's own result.
set -eu

if [ "$$" = 1 ]; then
    # Inside the guest. LW_TEST and LINEWRIGHT_PYTHON came along on the kernel's command line as environment.
    export PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/run
    echo "guest: begins"
    mount -t proc proc /proc
    mount -t sysfs sys /sys
    mount -t tmpfs run /run
    for module in can can-raw can-bcm can-dev vcan; do
        file=$(find "/usr/lib/uml/modules/$(uname -r)" -name "$module.ko*" | head -n 1)
        [ -z "$file" ] || insmod "$file" 2>/dev/null || echo "guest: $module not loaded (built in, or not needed)"
    done
    ip link set lo up
    # Whoever is late finds what came meanwhile.
    for limit in rmem_max rmem_default; do echo 8388608 >"/proc/sys/net/core/$limit" || true; done
    result=1
    if ip link add dev vcan0 type vcan && ip link set up vcan0; then
        echo "guest: $(uname -sr), $(ip -brief link show vcan0)"
        candump -L vcan0 >/run/candump.log &
        candump=$!
        sleep 1
        if timeout 400 "$LW_TEST" --nocapture --test-threads=1; then result=0; fi
        sleep 1
        kill "$candump"
        echo "guest: candump saw $(wc -l </run/candump.log) frames; the first 24:"
        head -n 24 /run/candump.log
    fi
    echo "guest: RESULT $result"
    halt -f 2>/dev/null || poweroff -f
fi

uml=$(command -v linux.uml || command -v linux || true)
if [ -z "$uml" ]; then
    echo "SKIPPED, not tested: no linux.uml here (Debian: apt install user-mode-linux can-utils kmod)" >&2
    exit 77
fi
here=$(cd "$(dirname "$0")" && pwd)
test=${1:-}
if [ -z "$test" ]; then
    test=$(cd "$here" && cargo test -p linewright-fieldbus --test vcan --no-run 2>&1 |
        sed -n 's/.*Executable.*(\(.*\))$/\1/p')
fi
case $test in
/*) ;;
*) test=$(cd "$here/../../.." && pwd)/$test ;;
esac
[ -x "$test" ] || { echo "no test binary: $test" >&2; exit 1; }
# A guest that has to wait for others is late by seconds: where it may, it goes before them.
first=
if chrt -f 1 true 2>/dev/null; then first="chrt -f 1"; fi
# Every system call inside is two switches between processes outside. On one processor they cost a tenth of what they cost
# from one processor to another and back: 20 us instead of 140 us, as measured in a virtual machine.
one=$(sed -n 's/^Cpus_allowed_list:.*[^0-9]\([0-9]*\)$/\1/p' /proc/self/status)
if [ -n "$one" ] && taskset -c "$one" true 2>/dev/null; then first="taskset -c $one $first"; fi
# No shell started by the guest can hang on a terminal; the guest ends within a few seconds, and is ended after 500.
out=$(mktemp)
preload=$(mktemp)
trap 'rm -f "$out" "$preload"' EXIT
if grep -qm1 '^flags.*amx' /proc/cpuinfo && cc -O2 -shared -fPIC -o "$preload" "$here/uml_registers.c"; then
    first="env LD_PRELOAD=$preload $first"
fi
timeout 500 $first "$uml" mem=1024M rootfstype=hostfs rootflags=/ rw "init=$here/vcan_uml.sh" "LW_TEST=$test" \
    ${LINEWRIGHT_PYTHON:+"LINEWRIGHT_PYTHON=$LINEWRIGHT_PYTHON"} \
    con=null con0=fd:0,fd:1 quiet </dev/null | tee "$out" || true
if ! grep -q 'guest: begins' "$out"; then
    # Nothing of ours has run.
    echo "SKIPPED, not tested: this user-mode Linux does not start on this processor, see above" >&2
    exit 77
fi
grep -q 'guest: RESULT 0' "$out"
