"""The Python package `canopen` doing what the benchmark `bus` does; started by it.

    peer.py boot COUNT INTERFACE   brings devices 1 to COUNT up, one after the other and each in a thread
    peer.py sdo NODE INTERFACE     reads and writes objects of a server
"""

import struct
import sys
import threading
import time

import canopen
from canopen.objectdictionary import ObjectDictionary


def connect(interface):
    network = canopen.Network()
    network.connect(interface="socketcan", channel=interface)
    return network


def boot(network, count):
    nodes = [network.add_node(number, ObjectDictionary()) for number in range(1, count + 1)]
    for node in nodes:
        node.sdo.RESPONSE_TIMEOUT = 5.0
    manager = network.send_periodic(0x77F, b"\x05", 0.25)

    def bring_up(node):
        up = threading.Event()
        network.subscribe(0x180 + node.id, lambda *_: up.set())
        assert node.sdo.upload(0x1000, 0) == b"\x91\x01\x03\x00"
        identity = [struct.unpack("<L", node.sdo.upload(0x1018, sub))[0] for sub in (1, 2, 3, 4)]
        assert identity == [0, 401, 0x10000, node.id], identity
        node.sdo.download(0x1017, 0, struct.pack("<H", 250))
        node.sdo.download(0x1016, 1, struct.pack("<L", 127 << 16 | 2000))
        node.sdo.upload(0x1001, 0)
        network.send_message(0, [1, node.id])
        assert up.wait(5), f"node {node.id} is not up"

    for threads in (False, True):
        network.send_message(0, [0x81, 0])
        time.sleep(0.3)
        began = time.monotonic()
        if threads:
            workers = [threading.Thread(target=bring_up, args=(node,)) for node in nodes]
            for worker in workers:
                worker.start()
            for worker in workers:
                worker.join()
        else:
            for node in nodes:
                bring_up(node)
        how = "each in a thread" if threads else "one after the other"
        print(f"  python: {count} devices, {how}: {1000 * (time.monotonic() - began):.1f} ms")
    manager.stop()


def sdo(network, number):
    node = network.add_node(number, ObjectDictionary())
    node.sdo.RESPONSE_TIMEOUT = 5.0
    times = []
    for _ in range(300):
        began = time.monotonic()
        assert node.sdo.upload(0x2002, 0) == b"\x01\x02\x03\x04"
        times.append(time.monotonic() - began)
    times.sort()
    print(f"  python: a number read: median {1e6 * times[150]:.0f} µs, best {1e6 * times[0]:.0f} µs")
    data = bytes((at * 7 + at // 251) & 0xFF for at in range(10_000))
    for name, how in (("segments", {}), ("blocks", {"block_transfer": True})):
        began = time.monotonic()
        with node.sdo.open(0x2000, 0, "wb", buffering=1024, size=len(data), **how) as stream:
            stream.write(data)
        written = time.monotonic() - began
        began = time.monotonic()
        with node.sdo.open(0x2000, 0, "rb", **how) as stream:
            got = stream.read()
        read = time.monotonic() - began
        assert got == data
        print(f"  python: 10000 bytes in {name}: written {1000 * written:.0f} ms, read {1000 * read:.0f} ms")


if __name__ == "__main__":
    part, number, interface = sys.argv[1:]
    network = connect(interface)
    {"boot": boot, "sdo": sdo}[part](network, int(number))
    network.disconnect()
