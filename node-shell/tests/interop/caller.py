"""Calls a service as rmw_cyclonedds does: Cyclone DDS, and sixteen bytes before the data that say whose request it is.

Those are the last eight bytes of the identity of the writer of requests and the number of the request (rmw_cyclonedds,
rmw_node.cpp and serdata.hpp, `cdds_request_header_t`). Here they are members of the types, which is the same on the wire.
Started by ../interop.rs inside a network namespace that has nothing but a loopback interface.
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int64, uint8, uint16, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Request(IdlStruct, typename="canopen_interfaces::srv::dds_::CORead_Request_"):
    guid: uint64
    number: int64
    index: uint16
    subindex: uint8


@dataclass
class Response(IdlStruct, typename="canopen_interfaces::srv::dds_::CORead_Response_"):
    guid: uint64
    number: int64
    success: bool
    data: uint32


SERVICE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile, Policy.History.KeepLast(10))
GUID = 0x1122334455667788


def main():
    participant = DomainParticipant(int(sys.argv[1]))
    requests = Topic(participant, "rq/transfer_line/clamp_1_io/sdo_readRequest", Request)
    responses = Topic(participant, "rr/transfer_line/clamp_1_io/sdo_readReply", Response)
    writer = DataWriter(participant, requests, qos=SERVICE)
    reader = DataReader(participant, responses, qos=SERVICE)
    end = time.time() + 20
    number = 0
    while time.time() < end:
        number += 1
        writer.write(Request(guid=GUID, number=number, index=0x1018, subindex=2))
        time.sleep(0.1)
        for answer in reader.take(10):
            ours = answer.guid == GUID and 1 <= answer.number <= number
            print("answer", ours, answer.success, answer.data, flush=True)
            return


main()
