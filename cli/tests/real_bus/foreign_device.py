#!/usr/bin/env python3
"""A CANopen device made of the Python package `canopen`, and a shuttle behind it; started by python.rs.

    foreign_device.py INTERFACE NODE EDS

Output 0 sends the shuttle out, output 1 back; input 0 is on while it is in, input 1 while it is out. It knows nothing of
Linewright: what it is told by SDO, NMT and PDO is what any manager could tell it. It runs until its standard input ends,
and says what it is told.
"""

import logging
import sys
import threading
import time

import canopen

TRAVEL_S = 0.2
INTERVAL_S = 0.1


class Shuttle:
    def __init__(self, node):
        self.node = node
        self.lock = threading.Lock()
        self.outputs = 0
        self.place = 0.0
        self.looked = time.monotonic()

    def move(self):
        now = time.monotonic()
        way = (now - self.looked) / TRAVEL_S
        self.looked = now
        self.place += {1: way, 2: -way}.get(self.outputs & 3, 0.0)
        self.place = min(1.0, max(0.0, self.place))
        return (1 if self.place == 0.0 else 0) | (2 if self.place == 1.0 else 0)

    def order(self, outputs):
        with self.lock:
            self.move()
            if outputs != self.outputs:
                print(f"outputs {outputs}", flush=True)
            self.outputs = outputs

    def inputs(self):
        with self.lock:
            return self.move()


def main(interface, node_id, eds):
    logging.disable(logging.WARNING)
    network = canopen.Network()
    network.connect(channel=interface, interface="socketcan")
    node = network.create_node(int(node_id, 0), eds)
    shuttle = Shuttle(node)
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()

    def written(index, subindex, od, data):
        print(f"written {index:04X}:{subindex:02X} {data.hex()}", flush=True)

    node.add_write_callback(written)
    node.tpdo.read(from_od=True)
    node.rpdo.read(from_od=True)
    node.rpdo[1].add_callback(lambda pdo: shuttle.order(pdo.data[0]) if node.nmt.state == "OPERATIONAL" else None)
    node.rpdo[1].subscribe()
    # Leaving "initialising" is what sends the boot-up message.
    node.nmt.state = "INITIALISING"
    node.nmt.state = "PRE-OPERATIONAL"
    said, sent, state = None, 0.0, None
    while not ended.wait(0.005):
        if node.nmt.state != state:
            state = node.nmt.state
            print(f"state {state}", flush=True)
            said = None
            if state != "OPERATIONAL":
                shuttle.order(0)
        inputs = shuttle.inputs()
        if state == "OPERATIONAL" and (inputs != said or time.monotonic() - sent > INTERVAL_S):
            node.tpdo[1].data[0] = inputs
            node.tpdo[1].transmit()
            said, sent = inputs, time.monotonic()
    network.disconnect()


main(*sys.argv[1:])
