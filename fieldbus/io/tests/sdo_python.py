#!/usr/bin/env python3
"""The Python package `canopen` as the other side of SDO transfers; started by sdo_python.rs.

    sdo_python.py client INTERFACE NODE   reads and writes objects of node NODE, and checks what it gets
    sdo_python.py server INTERFACE NODE   is node NODE until it is killed

The objects are those of sdo_python.rs: 2000h is a domain that can be read and written, 2001h is read only, 2002h is an
unsigned number of 32 bits.
"""

import logging
import struct
import sys
import time

import canopen
from canopen.objectdictionary import ODVariable, ObjectDictionary, datatypes

LENGTHS = [1, 2, 3, 4, 5, 7, 8, 14, 20, 63, 64, 65, 127, 500, 889, 890, 2000]


def pattern(length):
    return bytes((at * 7 + at // 251) & 0xFF for at in range(length))


def dictionary():
    od = ObjectDictionary()
    for index, name, kind, access in (
        (0x2000, "Domain", datatypes.DOMAIN, "rw"),
        (0x2001, "Constant", datatypes.DOMAIN, "ro"),
        (0x2002, "Number", datatypes.UNSIGNED32, "rw"),
    ):
        variable = ODVariable(name, index, 0)
        variable.data_type = kind
        variable.access_type = access
        od.add_object(variable)
    return od


def connect(interface):
    network = canopen.Network()
    network.connect(interface="socketcan", channel=interface)
    return network


def refused(code, act):
    try:
        act()
    except canopen.SdoAbortedError as error:
        assert error.code == code, f"aborted with {error.code:08X}, expected {code:08X}"
    else:
        raise AssertionError(f"not refused, expected {code:08X}")


def write(sdo, data, **how):
    # What fits one write of the raw stream goes out as it comes.
    with sdo.open(0x2000, 0, "wb", buffering=1024, size=len(data), **how) as stream:
        stream.write(data)


def read(sdo, **how):
    with sdo.open(0x2000, 0, "rb", **how) as stream:
        return stream.read()


def client(interface, node):
    network = connect(interface)
    remote = network.add_node(node, dictionary())
    sdo = remote.sdo
    sdo.RESPONSE_TIMEOUT = 2.0
    transfers = 0
    for length in LENGTHS:
        data = pattern(length)
        ways = [
            ("expedited or segmented", {}),
            ("segmented", {"force_segment": True}),
            ("blocks", {"block_transfer": True}),
            ("blocks without checksum", {"block_transfer": True, "request_crc_support": False}),
        ]
        for name, how in ways:
            write(sdo, b"nothing", force_segment=True)
            started = time.monotonic()
            write(sdo, data, **how)
            took = time.monotonic() - started
            # Each way of writing is checked by each way of reading.
            for back in ({}, {"block_transfer": True}, {"block_transfer": True, "request_crc_support": False}):
                got = read(sdo, **back)
                assert got == data, f"{length} bytes by {name}, read back {back}: {got!r}"
                transfers += 1
            transfers += 2
            if length == 2000:
                print(f"python: {length} bytes written in {took * 1000:.1f} ms, {name}")
        started = time.monotonic()
        read(sdo)
        if length == 2000:
            print(f"python: {length} bytes read in {(time.monotonic() - started) * 1000:.1f} ms, segmented")
            started = time.monotonic()
            read(sdo, block_transfer=True)
            print(f"python: {length} bytes read in {(time.monotonic() - started) * 1000:.1f} ms, blocks")
    sdo.download(0x2002, 0, struct.pack("<L", 0x12345678))
    assert sdo.upload(0x2002, 0) == b"\x78\x56\x34\x12"
    refused(0x06070010, lambda: sdo.download(0x2002, 0, b"\x01\x02"))
    refused(0x06010002, lambda: sdo.download(0x2001, 0, b"\x01"))
    refused(0x06010002, lambda: sdo.download(0x2001, 0, b"too long for one frame"))
    refused(0x06020000, lambda: sdo.upload(0x2FFF, 0))
    refused(0x06020000, lambda: sdo.open(0x2FFF, 0, "rb", block_transfer=True))
    refused(0x05040005, lambda: sdo.download(0x2000, 0, bytes(5000)))
    assert sdo.upload(0x2002, 0) == b"\x78\x56\x34\x12", "nothing refused has changed anything"
    network.disconnect()
    print(f"python: {transfers} transfers, every byte as written")


def server(interface, node):
    # It logs what it refuses, with a trace.
    logging.disable(logging.CRITICAL)
    network = connect(interface)
    local = canopen.LocalNode(node, dictionary())
    network.add_node(local)
    local.set_data(0x2000, 0, b"initial")
    local.set_data(0x2001, 0, b"a constant of the other side")
    local.set_data(0x2002, 0, struct.pack("<L", 7))
    print("ready", flush=True)
    while True:
        time.sleep(1)


if __name__ == "__main__":
    role, interface, node = sys.argv[1:]
    {"client": client, "server": server}[role](interface, int(node))
