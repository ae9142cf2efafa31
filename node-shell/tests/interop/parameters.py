"""Asks for and sets parameters as rclpy under rmw_cyclonedds does (see caller.py for the form of requests), and listens for changes.

Prints one line for each answer. Started by ../interop.rs inside a network namespace that has nothing but a loopback interface.
"""

import sys
import time
from dataclasses import dataclass, field

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import byte, float64, int32, int64, sequence, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

NODE = sys.argv[2]
M, S = "rcl_interfaces::msg::dds_::", "rcl_interfaces::srv::dds_::"


@dataclass
class Value(IdlStruct, typename=M + "ParameterValue_"):
    type: uint8 = 0
    bool_value: bool = False
    integer_value: int64 = 0
    double_value: float64 = 0.0
    string_value: str = ""
    byte_array_value: sequence[byte] = field(default_factory=list)
    bool_array_value: sequence[bool] = field(default_factory=list)
    integer_array_value: sequence[int64] = field(default_factory=list)
    double_array_value: sequence[float64] = field(default_factory=list)
    string_array_value: sequence[str] = field(default_factory=list)


@dataclass
class Parameter(IdlStruct, typename=M + "Parameter_"):
    name: str
    value: Value


@dataclass
class FloatRange(IdlStruct, typename=M + "FloatingPointRange_"):
    from_value: float64
    to_value: float64
    step: float64


@dataclass
class IntRange(IdlStruct, typename=M + "IntegerRange_"):
    from_value: int64
    to_value: int64
    step: uint64


@dataclass
class Descriptor(IdlStruct, typename=M + "ParameterDescriptor_"):
    name: str
    type: uint8
    description: str
    additional_constraints: str
    read_only: bool
    dynamic_typing: bool
    floating_point_range: sequence[FloatRange, 1]
    integer_range: sequence[IntRange, 1]


@dataclass
class SetResult(IdlStruct, typename=M + "SetParametersResult_"):
    successful: bool
    reason: str


@dataclass
class ListResult(IdlStruct, typename=M + "ListParametersResult_"):
    names: sequence[str]
    prefixes: sequence[str]


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Event(IdlStruct, typename=M + "ParameterEvent_"):
    stamp: Time
    node: str
    new_parameters: sequence[Parameter]
    changed_parameters: sequence[Parameter]
    deleted_parameters: sequence[Parameter]


@dataclass
class DescribeAsk(IdlStruct, typename=S + "DescribeParameters_Request_"):
    guid: uint64
    number: int64
    names: sequence[str]


@dataclass
class DescribeAnswer(IdlStruct, typename=S + "DescribeParameters_Response_"):
    guid: uint64
    number: int64
    descriptors: sequence[Descriptor]


@dataclass
class GetAsk(IdlStruct, typename=S + "GetParameters_Request_"):
    guid: uint64
    number: int64
    names: sequence[str]


@dataclass
class GetAnswer(IdlStruct, typename=S + "GetParameters_Response_"):
    guid: uint64
    number: int64
    values: sequence[Value]


@dataclass
class TypesAsk(IdlStruct, typename=S + "GetParameterTypes_Request_"):
    guid: uint64
    number: int64
    names: sequence[str]


@dataclass
class TypesAnswer(IdlStruct, typename=S + "GetParameterTypes_Response_"):
    guid: uint64
    number: int64
    types: sequence[uint8]


@dataclass
class ListAsk(IdlStruct, typename=S + "ListParameters_Request_"):
    guid: uint64
    number: int64
    prefixes: sequence[str]
    depth: uint64


@dataclass
class ListAnswer(IdlStruct, typename=S + "ListParameters_Response_"):
    guid: uint64
    number: int64
    result: ListResult


@dataclass
class SetAsk(IdlStruct, typename=S + "SetParameters_Request_"):
    guid: uint64
    number: int64
    parameters: sequence[Parameter]


@dataclass
class SetAnswer(IdlStruct, typename=S + "SetParameters_Response_"):
    guid: uint64
    number: int64
    results: sequence[SetResult]


@dataclass
class SetAllAsk(IdlStruct, typename=S + "SetParametersAtomically_Request_"):
    guid: uint64
    number: int64
    parameters: sequence[Parameter]


@dataclass
class SetAllAnswer(IdlStruct, typename=S + "SetParametersAtomically_Response_"):
    guid: uint64
    number: int64
    result: SetResult


SERVICE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile, Policy.History.KeepLast(1000))
GUID = 0x1122334455667788


class Client:
    def __init__(self, participant, name, ask, answer):
        self.writer = DataWriter(participant, Topic(participant, f"rq{NODE}/{name}Request", ask), qos=SERVICE)
        self.reader = DataReader(participant, Topic(participant, f"rr{NODE}/{name}Reply", answer), qos=SERVICE)
        self.ask, self.number = ask, 0

    def call(self, *fields):
        end = time.time() + 20
        while time.time() < end:
            self.number += 1
            self.writer.write(self.ask(GUID, self.number, *fields))
            until = time.time() + 0.5
            while time.time() < until:
                for answer in self.reader.take(10):
                    if answer.guid == GUID and answer.number == self.number:
                        return answer
                time.sleep(0.01)
        sys.exit("no answer")


def text(name, value):
    return Parameter(name, Value(type=4, string_value=value))


def shown(parameter):
    value = parameter.value
    return parameter.name, [None, value.bool_value, value.integer_value, value.double_value, value.string_value][value.type]


def main():
    participant = DomainParticipant(int(sys.argv[1]))
    events = DataReader(participant, Topic(participant, "rt/parameter_events", Event), qos=SERVICE)
    listed = Client(participant, "list_parameters", ListAsk, ListAnswer).call([], 0).result
    print("list", listed.names, listed.prefixes, flush=True)
    found = Client(participant, "describe_parameters", DescribeAsk, DescribeAnswer).call(["rate_s", "mode", "none"])
    for one in found.descriptors:
        ranges = [(r.from_value, r.to_value) for r in one.floating_point_range]
        print("describe", one.name, one.type, one.read_only, ranges, one.description, one.additional_constraints, flush=True)
    types = Client(participant, "get_parameter_types", TypesAsk, TypesAnswer).call(["rate_s", "none", "mode"])
    print("types", list(types.types), flush=True)
    setter = Client(participant, "set_parameters", SetAsk, SetAnswer)
    # Values that are there already: no change, until the topic of changes is discovered on both sides.
    setter.call([text("mode", "slow")])
    time.sleep(1)
    changes = [Parameter("rate_s", Value(type=3, double_value=2.5)), Parameter("rate_s", Value(type=3, double_value=99.0))]
    for one in setter.call([*changes, text("fixed", "x"), text("mode", "fast")]).results:
        print("set", one.successful, one.reason, flush=True)
    together = Client(participant, "set_parameters_atomically", SetAllAsk, SetAllAnswer)
    one = together.call([text("mode", "slow"), Parameter("rate_s", Value(type=2, integer_value=3))]).result
    print("all", one.successful, one.reason, flush=True)
    one = together.call([text("mode", "slow"), Parameter("rate_s", Value(type=3, double_value=3.0))]).result
    print("all", one.successful, one.reason, flush=True)
    values = Client(participant, "get_parameters", GetAsk, GetAnswer).call(["rate_s", "mode", "none"]).values
    print("get", [(value.type, value.double_value, value.string_value) for value in values], flush=True)
    time.sleep(0.3)
    for event in events.take(50):
        if event.changed_parameters:
            print("event", event.node, [shown(one) for one in event.changed_parameters], flush=True)


main()
