"""Gives a command by a service as rclpy does above rmw_cyclonedds, and reads the log as `ros2 topic echo /rosout` does.

The header of requests is described in caller.py. Prints what it hears, one line each.
Started by ../interop.rs inside a network namespace that has nothing but a loopback interface.
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int32, int64, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Request(IdlStruct, typename="linewright_msgs::srv::dds_::SetMode_Request_"):
    guid: uint64
    number: int64
    command: uint8
    station: str
    stamp: Time
    by: str
    note: str


@dataclass
class Response(IdlStruct, typename="linewright_msgs::srv::dds_::SetMode_Response_"):
    guid: uint64
    number: int64
    accepted: bool
    reason: str
    epoch: uint64


@dataclass
class Log(IdlStruct, typename="rcl_interfaces::msg::dds_::Log_"):
    stamp: Time
    level: uint8
    name: str
    msg: str
    file: str
    function: str
    line: uint32


RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))
SERVICE = Qos(RELIABLE, Policy.Durability.Volatile, Policy.History.KeepLast(10))
# That of rclcpp for /rosout.
LOG = Qos(RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(1000))
GUID = 0x1122334455667788


def main():
    participant = DomainParticipant(int(sys.argv[1]))
    requests = Topic(participant, "rq/transfer_line/coordinator/set_modeRequest", Request)
    responses = Topic(participant, "rr/transfer_line/coordinator/set_modeReply", Response)
    writer = DataWriter(participant, requests, qos=SERVICE)
    reader = DataReader(participant, responses, qos=SERVICE)
    log = DataReader(participant, Topic(participant, "rt/rosout", Log), qos=LOG)
    answered, logged = False, False
    end, number = time.time() + 20, 0
    while time.time() < end and not (answered and logged):
        number += 1
        if not answered:
            stamp = Time(sec=1700000000, nanosec=5)
            writer.write(Request(GUID, number, 5, "robot", stamp, "ada", "a part lies there"))
        time.sleep(0.1)
        for answer in reader.take(10)[:1]:
            if not answered:
                print("answer", answer.guid == GUID, answer.accepted, answer.reason, answer.epoch, flush=True)
            answered = True
        for line in log.take(100):
            if line.msg.startswith("a late reader") and not logged:
                print("log", line.level, line.name, line.msg, line.stamp.sec > 1700000000, flush=True)
                logged = True


main()
