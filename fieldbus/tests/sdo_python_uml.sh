#!/bin/sh
# Our SDO client and server against the Python package `canopen`, over a real CAN interface: sdo_python.rs on the
# kernel's own vcan0 if there is one, else inside a user-mode Linux (vcan_uml.sh next to this file).
#
# Needs a Python with `canopen` and `python-can`: LINEWRIGHT_PYTHON names it, else python3 is tried.
#
#   python3 -m venv DIR && DIR/bin/pip install canopen python-can
#   LINEWRIGHT_PYTHON=DIR/bin/python fieldbus/tests/sdo_python_uml.sh [BINARY]
set -eu

here=$(cd "$(dirname "$0")" && pwd)
python=$(command -v "${LINEWRIGHT_PYTHON:-python3}" || true)
if [ -z "$python" ] || ! "$python" -c 'import can, canopen' 2>/dev/null; then
    echo "SKIPPED, not tested: no Python with canopen here (pip install canopen python-can; LINEWRIGHT_PYTHON)" >&2
    exit 77
fi
LINEWRIGHT_PYTHON=$python
export LINEWRIGHT_PYTHON
test=${1:-}
if [ -z "$test" ]; then
    test=$(cd "$here" && cargo test -p linewright-fieldbus --test sdo_python --no-run 2>&1 |
        sed -n 's/.*Executable.*(\(.*\))$/\1/p')
fi
case $test in
/*) ;;
*) test=$(cd "$here/../.." && pwd)/$test ;;
esac
if [ -e /sys/class/net/vcan0 ]; then
    exec "$test" --nocapture --test-threads=1
fi
exec "$here/vcan_uml.sh" "$test"
