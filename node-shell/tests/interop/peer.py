"""A DDS peer that shares no code with us: Cyclone DDS under the names and types of ROS 2.

Commands the line's mode as `ros2 topic pub` would, and prints what it hears, one word list per line.
Started by ../interop.rs inside a network namespace that has nothing but a loopback interface.
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int32, sequence, uint8, uint16, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class String_(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    data: str


@dataclass
class Time_(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header_(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time_
    frame_id: str


@dataclass
class Answer_(IdlStruct, typename="linewright_msgs::msg::dds_::Answer_"):
    station: str
    boot_id: uint64
    request_number: uint64
    agreed: bool
    in_the_way: str


@dataclass
class StationState_(IdlStruct, typename="linewright_msgs::msg::dds_::StationState_"):
    header: Header_
    boot_id: uint64
    sequence: uint64
    station: str
    description: uint64
    mode_epoch: uint64
    coordinator_boot_id: uint64
    mode: uint8
    lifecycle: uint8
    generation: uint64
    cycle: int32
    done: sequence[int32]
    started: sequence[int32]
    places: sequence[uint8]
    recovering_home: bool
    at_home: bool
    round: int32
    stopped: bool
    selector_manual: bool
    devices_valid: bool
    measured: sequence[uint8, 16]
    measured_age_ms: uint32
    position_lost: bool
    placed: bool
    place: uint16
    incomplete: sequence[uint16]
    stop_causes: sequence[uint8]
    operation: str
    fault: str
    blocked_by: sequence[str]
    request_number: uint64
    request_operations: sequence[uint16]
    answers: sequence[Answer_]


def qos(reliable, latched, depth):
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=1)) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
    )


def say(*words):
    print(*words, flush=True)


def main():
    participant = DomainParticipant(int(sys.argv[1]))

    def topic(name, kind):
        return Topic(participant, "rt/transfer_line/" + name, kind)

    # What `ros2 topic pub` offers and `ros2 topic echo` asks for.
    command = DataWriter(participant, topic("mode_cmd", String_), qos=qos(True, False, 10))
    readers = {
        "latched-text": DataReader(participant, topic("mode_text", String_), qos=qos(True, True, 1)),
        "volatile-text": DataReader(participant, topic("mode_text", String_), qos=qos(False, False, 10)),
        "state": DataReader(participant, topic("s1/state", StationState_), qos=qos(True, True, 1)),
    }
    say("ready")
    end = time.time() + 20
    count = 0
    while time.time() < end:
        count += 1
        if count % 10 == 0:
            command.write(String_(data="auto"))
        for name, reader in readers.items():
            for sample in reader.take(10):
                if name == "state":
                    answers = [(a.station, a.boot_id, a.agreed, a.in_the_way) for a in sample.answers]
                    say(name, sample.station, sample.boot_id, sample.description, list(sample.done), list(sample.places),
                        list(sample.incomplete), list(sample.blocked_by), sample.request_number, answers)
                else:
                    say(name, sample.data)
        time.sleep(0.02)


main()
