#!/usr/bin/env python3
"""The Python package `canopen` as manager of the simulated devices; started by python.rs.

    foreign_manager.py INTERFACE DEVICES

DEVICES is the directory of the EDS files. The devices are those of the shipped line: node 21h is the clamp's I/O
(outputs open, close; inputs LS_open, LS_closed), node 23h the drive of the mill's positioning slide.

It says what it has seen, line by line, and ends with `OK`; what is not as it should be raises.
"""

import logging
import os
import sys
import time

import canopen
from canopen.profiles.p402 import BaseNode402

CLAMP, SLIDE = 0x21, 0x23
MANAGER = 0x77F


def until(what, holds, seconds=5.0):
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise TimeoutError(f"not seen within {seconds} s: {what}")
        time.sleep(0.005)
    print(f"seen: {what}", flush=True)


def same(what, got, expected):
    if got != expected:
        raise AssertionError(f"{what}: {got!r} instead of {expected!r}")
    print(f"{what}: {got!r}", flush=True)


def refused(what, code, act):
    try:
        act()
    except canopen.SdoAbortedError as error:
        return same(f"{what} is refused", f"{error.code:08X}", f"{code:08X}")
    raise AssertionError(f"{what} is not refused")


def identity_and_sdo(node):
    same("device type", node.sdo[0x1000].raw, 0x00030191)
    same("vendor", node.sdo[0x1018][1].raw, 0)
    same("product", node.sdo[0x1018][2].raw, 401)
    same("revision", node.sdo[0x1018][3].raw, 0x00010000)
    same("name, in segments", node.sdo[0x1008].raw, node.object_dictionary[0x1008].default)
    with node.sdo[0x1008].open("rb", block_transfer=True) as file:
        same("name, in a block", file.read().decode(), node.object_dictionary[0x1008].default)
    node.sdo[0x1017].raw = 40
    same("heartbeat written", node.sdo[0x1017].raw, 40)
    refused("a constant", 0x06010002, lambda: setattr(node.sdo[0x1000], "raw", 1))
    refused("what is not there", 0x06020000, lambda: node.sdo.upload(0x2345, 0))
    refused("a missing subindex", 0x06090011, lambda: node.sdo.upload(0x1018, 9))
    refused("two bytes for one", 0x06070010, lambda: node.sdo.download(0x6206, 1, b"\0\0"))


def nmt_and_heartbeat(network, node):
    until("its heartbeat", lambda: node.nmt.timestamp is not None)
    same("state", node.nmt.state, "PRE-OPERATIONAL")
    for order, state in (("OPERATIONAL", "OPERATIONAL"), ("STOPPED", "STOPPED"), ("PRE-OPERATIONAL", "PRE-OPERATIONAL")):
        node.nmt.state = order
        # The order itself makes the package believe in it: what counts is what the device says afterwards.
        time.sleep(0.02)
        node.nmt.wait_for_heartbeat(2)
        same(f"ordered {order}", node.nmt.state, state)
    node.nmt.send_command(0x81)
    node.nmt.wait_for_bootup(5)
    print("seen: boot-up after a reset", flush=True)
    until("pre-operational", lambda: node.nmt.state == "PRE-OPERATIONAL")


def process_data(network, node):
    node.tpdo.read()
    node.rpdo.read()
    same("TPDO1", node.tpdo[1].cob_id, 0x180 + CLAMP)
    same("RPDO1", node.rpdo[1].cob_id, 0x200 + CLAMP)
    heard = []
    node.tpdo[1].add_callback(lambda pdo: heard.append(pdo.data[0]))
    node.nmt.state = "OPERATIONAL"
    until("its inputs on entering operational", lambda: bool(heard))
    same("it stands open", heard[-1] & 3, 1)
    node.rpdo[1].data[0] = 2
    node.rpdo[1].transmit()
    until("neither open nor closed", lambda: any(bits & 3 == 0 for bits in heard))
    until("closed", lambda: heard[-1] & 3 == 2)
    same("output 6200h", node.sdo[0x6200][1].raw & 3, 2)
    node.rpdo[1].data[0] = 1
    node.rpdo[1].transmit()
    until("open", lambda: heard[-1] & 3 == 1)


def silence_of_the_manager(network, node):
    """It watches our heartbeat; when that stops it says so and lets go of its outputs."""
    node.sdo[0x1016][1].raw = MANAGER - 0x700 << 16 | 200
    beat = network.send_periodic(MANAGER, [5], 0.05)
    time.sleep(0.3)
    node.rpdo[1].data[0] = 2
    node.rpdo[1].transmit()
    until("an output on", lambda: node.sdo[0x6200][1].raw & 3 == 2)
    node.emcy.reset()
    beat.stop()
    error = node.emcy.wait(0x8130, 3)
    same("emergency", f"{error.code:04X}, register {error.register:02X}", "8130, register 11")
    until("its outputs off", lambda: node.sdo[0x6200][1].raw & 3 == 0)
    same("error register", node.sdo[0x1001].raw, 0x11)
    until("no longer operational", lambda: node.nmt.state == "PRE-OPERATIONAL")
    node.sdo[0x1016][1].raw = 0


def drive(network, node):
    """A drive by the package's own profile: through its states, to a place and back."""
    same("device type", node.sdo[0x1000].raw & 0xFFFF, 402)
    # It believes process data alone, and those come when the drive is started.
    node.setup_402_state_machine(read_pdos=True)
    node.nmt.state = "OPERATIONAL"
    until("its statusword", lambda: node.state == "SWITCH ON DISABLED")
    node.state = "READY TO SWITCH ON"
    same("state", node.state, "READY TO SWITCH ON")
    node.state = "OPERATION ENABLED"
    same("state", node.state, "OPERATION ENABLED")
    node.op_mode = "PROFILED POSITION"
    same("mode", node.op_mode, "PROFILED POSITION")
    node.sdo[0x6081].raw = 20000
    node.sdo[0x6083].raw = 200000
    node.sdo[0x6084].raw = 200000
    for target in (8000, 0):
        node.sdo[0x607A].raw = target
        node.controlword = 0x0F
        node.controlword = 0x3F
        until("set-point acknowledged", lambda: node.statusword & 0x1000)
        node.controlword = 0x0F
        until(f"it stands at {target}", lambda: abs(node.sdo[0x6064].raw - target) <= 5 and node.statusword & 0x400)
    node.state = "SWITCH ON DISABLED"
    same("state", node.state, "SWITCH ON DISABLED")


def main(interface, devices):
    logging.disable(logging.WARNING)
    network = canopen.Network()
    network.connect(channel=interface, interface="socketcan")
    try:
        clamp = network.add_node(CLAMP, os.path.join(devices, "linewright-io.eds"))
        slide = network.add_node(BaseNode402(SLIDE, os.path.join(devices, "linewright-drive.eds")))
        network.scanner.search(limit=127)
        time.sleep(1)
        same("nodes found", [hex(node) for node in sorted(network.scanner.nodes)], [hex(n) for n in (1, 17, 33, 34, 35, 36)])
        identity_and_sdo(clamp)
        nmt_and_heartbeat(network, clamp)
        process_data(network, clamp)
        silence_of_the_manager(network, clamp)
        drive(network, slide)
    finally:
        network.disconnect()
    print("OK")


main(*sys.argv[1:])
