#!/bin/sh
# Runs a whole line on real CAN sockets inside a user-mode Linux, for machines whose own kernel has no CAN: every
# process, DDS on loopback, the devices on vcan0, candump beside it. Slow and exhaustive enough to be a command of its
# own; docs/can.md has its last result.
#
# Needs, on Debian: user-mode-linux, can-utils, kmod, iproute2.
#
#   cli/tests/line_on_vcan_uml.sh            builds the program and boots the guest
#   cli/tests/line_on_vcan_uml.sh PROGRAM    runs that `linewright` inside
#
# The guest starts this same script as its init. It has one slow processor, so the line gets patient timings.
set -u

if [ "$$" = 1 ]; then
    # Inside the guest. LW_* came along on the kernel's command line as environment.
    export PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/run
    mount -t proc proc /proc
    mount -t sysfs sys /sys
    mount -t tmpfs run /run
    for module in can can-raw can-dev vcan; do
        file=$(find "/usr/lib/uml/modules/$(uname -r)" -name "$module.ko*" | head -n 1)
        [ -z "$file" ] || insmod "$file" 2>/dev/null || echo "guest: $module not loaded (built in, or not needed)"
    done
    ip link set lo up
    ip link add dev vcan0 type vcan && ip link set up vcan0
    candump -L vcan0 >/run/candump.log &
    "$LW_PROGRAM" new transfer-line --dir /run/line
    printf '\n[timing]\nrefresh_ms = 200\nstale_ms = 2000\nlease_ms = 4000\nheartbeat_ms = 200\nheartbeat_timeout_ms = 2000\n' \
        >>/run/line/line.toml
    timeout 240 "$LW_PROGRAM" run /run/line --cycles 3 --json --state-dir /run/state
    echo "guest: RESULT $?"
    grep -h "devices on" /run/state/*.log
    echo "guest: candump saw $(wc -l </run/candump.log) frames"
    halt -f 2>/dev/null || poweroff -f
fi

uml=$(command -v linux.uml || command -v linux || true)
if [ -z "$uml" ]; then
    echo "SKIPPED, not tested: no linux.uml here (Debian: apt install user-mode-linux can-utils kmod)" >&2
    exit 77
fi
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
program=${1:-$root/target/release/linewright}
[ -n "${1:-}" ] || (cd "$root" && cargo build --release -p linewright) || exit 1
out=$(mktemp)
trap 'rm -f "$out"' EXIT
timeout 300 "$uml" mem=1024M rootfstype=hostfs rootflags=/ rw "init=$here/line_on_vcan_uml.sh" \
    "LW_PROGRAM=$program" con=null con0=fd:0,fd:1 quiet </dev/null 2>&1 | tee "$out" || true
grep -q 'guest: RESULT 0' "$out"
