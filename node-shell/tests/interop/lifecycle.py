"""Asks for the states of a node and changes them as rclpy under rmw_cyclonedds does (see caller.py for the form of requests), and listens for transitions.

Prints one line for each answer. Started by ../interop.rs inside a network namespace that has nothing but a loopback interface.
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int64, sequence, uint8, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

NODE = sys.argv[2]
M, S = "lifecycle_msgs::msg::dds_::", "lifecycle_msgs::srv::dds_::"


@dataclass
class State(IdlStruct, typename=M + "State_"):
    id: uint8
    label: str


@dataclass
class Transition(IdlStruct, typename=M + "Transition_"):
    id: uint8
    label: str


@dataclass
class Description(IdlStruct, typename=M + "TransitionDescription_"):
    transition: Transition
    start_state: State
    goal_state: State


@dataclass
class Event(IdlStruct, typename=M + "TransitionEvent_"):
    timestamp: uint64
    transition: Transition
    start_state: State
    goal_state: State


@dataclass
class ChangeAsk(IdlStruct, typename=S + "ChangeState_Request_"):
    guid: uint64
    number: int64
    transition: Transition


@dataclass
class ChangeAnswer(IdlStruct, typename=S + "ChangeState_Response_"):
    guid: uint64
    number: int64
    success: bool


@dataclass
class StateAsk(IdlStruct, typename=S + "GetState_Request_"):
    guid: uint64
    number: int64
    structure_needs_at_least_one_member: uint8


@dataclass
class StateAnswer(IdlStruct, typename=S + "GetState_Response_"):
    guid: uint64
    number: int64
    current_state: State


@dataclass
class StatesAsk(IdlStruct, typename=S + "GetAvailableStates_Request_"):
    guid: uint64
    number: int64
    structure_needs_at_least_one_member: uint8


@dataclass
class StatesAnswer(IdlStruct, typename=S + "GetAvailableStates_Response_"):
    guid: uint64
    number: int64
    available_states: sequence[State]


@dataclass
class TransitionsAsk(IdlStruct, typename=S + "GetAvailableTransitions_Request_"):
    guid: uint64
    number: int64
    structure_needs_at_least_one_member: uint8


@dataclass
class TransitionsAnswer(IdlStruct, typename=S + "GetAvailableTransitions_Response_"):
    guid: uint64
    number: int64
    available_transitions: sequence[Description]


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
            until = time.time() + 1
            while time.time() < until:
                for answer in self.reader.take(10):
                    if answer.guid == GUID and answer.number == self.number:
                        return answer
                time.sleep(0.01)
        sys.exit("no answer")


def shown(found):
    return f"{found.transition.label} [{found.transition.id}] {found.start_state.label} {found.goal_state.label}"


def main():
    participant = DomainParticipant(int(sys.argv[1]))
    events = DataReader(participant, Topic(participant, f"rt{NODE}/transition_event", Event), qos=SERVICE)
    state = Client(participant, "get_state", StateAsk, StateAnswer)
    print("state", state.call(0).current_state.label, flush=True)
    states = Client(participant, "get_available_states", StatesAsk, StatesAnswer).call(0).available_states
    print("states", [(one.id, one.label) for one in states], flush=True)
    available = Client(participant, "get_available_transitions", TransitionsAsk, TransitionsAnswer)
    print("available", [shown(one) for one in available.call(0).available_transitions], flush=True)
    graph = Client(participant, "get_transition_graph", TransitionsAsk, TransitionsAnswer).call(0)
    print("graph", len(graph.available_transitions), flush=True)
    change = Client(participant, "change_state", ChangeAsk, ChangeAnswer)
    # It leads nowhere: both sides know each other from then on.
    print("change", change.call(Transition(4, "")).success, flush=True)
    time.sleep(1)
    for one in [Transition(1, ""), Transition(0, "activate"), Transition(1, "configure"), Transition(3, "deactivate")]:
        print("change", change.call(one).success, state.call(0).current_state.label, flush=True)
    time.sleep(0.3)
    for event in events.take(50):
        print("event", shown(event), event.timestamp > 1_600_000_000_000_000_000, flush=True)


main()
