"""Asks for an action as rclpy does above rmw_cyclonedds: three services with sixteen bytes before the data, two topics.

The header is described in caller.py. Names and types are those of rosidl for an action (`_action/send_goal` and so on).
Sends a goal and waits for its result, then one that it cancels. Prints what it hears, one line each.
Started by ../interop.rs inside a network namespace that has nothing but a loopback interface.
"""

import sys
import time
import uuid
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, int8, int32, int64, sequence, uint8, uint16, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

OURS = "linewright_msgs::action::dds_::RunTask_"


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class GoalInfo(IdlStruct, typename="action_msgs::msg::dds_::GoalInfo_"):
    goal_id: array[uint8, 16]
    stamp: Time


@dataclass
class SendGoal(IdlStruct, typename=OURS + "SendGoal_Request_"):
    guid: uint64
    number: int64
    goal_id: array[uint8, 16]
    memory: uint64
    epoch: uint64
    id: uint64
    task: str
    parameter_names: sequence[str]
    parameters: sequence[int32]
    part: str
    limit_ms: uint32


@dataclass
class Accepted(IdlStruct, typename=OURS + "SendGoal_Response_"):
    guid: uint64
    number: int64
    accepted: bool
    stamp: Time


@dataclass
class GetResult(IdlStruct, typename=OURS + "GetResult_Request_"):
    guid: uint64
    number: int64
    goal_id: array[uint8, 16]


@dataclass
class Result(IdlStruct, typename=OURS + "GetResult_Response_"):
    guid: uint64
    number: int64
    status: int8
    epoch: uint64
    id: uint64
    end: uint8
    code: uint16
    text: str


@dataclass
class Cancel(IdlStruct, typename="action_msgs::srv::dds_::CancelGoal_Request_"):
    guid: uint64
    number: int64
    goal_info: GoalInfo


@dataclass
class Cancelled(IdlStruct, typename="action_msgs::srv::dds_::CancelGoal_Response_"):
    guid: uint64
    number: int64
    return_code: int8
    goals_canceling: sequence[GoalInfo]


@dataclass
class Feedback(IdlStruct, typename=OURS + "FeedbackMessage_"):
    goal_id: array[uint8, 16]
    phase: uint8
    operation: str
    step: uint16
    steps: uint16


@dataclass
class Status(IdlStruct, typename="action_msgs::msg::dds_::GoalStatus_"):
    goal_info: GoalInfo
    status: int8


@dataclass
class Statuses(IdlStruct, typename="action_msgs::msg::dds_::GoalStatusArray_"):
    status_list: sequence[Status]


RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))
SERVICE = Qos(RELIABLE, Policy.Durability.Volatile, Policy.History.KeepLast(10))
LATCHED = Qos(RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
GUID = 0x1122334455667788
END = time.time() + 25


class Service:
    """Asks again until an answer to one of its questions comes."""

    def __init__(self, participant, name, request, response):
        self.writer = DataWriter(participant, Topic(participant, f"rq/{name}Request", request), qos=SERVICE)
        self.reader = DataReader(participant, Topic(participant, f"rr/{name}Reply", response), qos=SERVICE)
        self.number = 0

    def ask(self, make, patience=0.5):
        while time.time() < END:
            self.number += 1
            self.writer.write(make(self.number))
            until = time.time() + patience
            while time.time() < until:
                for answer in self.reader.take(10):
                    if answer.guid == GUID and 1 <= answer.number <= self.number:
                        return answer
                time.sleep(0.02)
        sys.exit("no answer")


def main():
    participant = DomainParticipant(int(sys.argv[1]))
    name = "cell/m1/run_task/_action/"
    goals = Service(participant, name + "send_goal", SendGoal, Accepted)
    results = Service(participant, name + "get_result", GetResult, Result)
    cancels = Service(participant, name + "cancel_goal", Cancel, Cancelled)
    feedback = DataReader(participant, Topic(participant, f"rt/{name}feedback", Feedback), qos=SERVICE)
    status = DataReader(participant, Topic(participant, f"rt/{name}status", Statuses), qos=LATCHED)

    def begin(task, number):
        # Another goal each time: one that was heard and whose answer was lost would be rejected.
        ids = {}

        def make(n):
            ids[n] = uuid.uuid4().bytes
            return SendGoal(GUID, n, list(ids[n]), 9, 1, number, task, ["slot"], [-3], "part 7", 1000)

        answer = goals.ask(make, patience=2.0)
        print("accepted", answer.accepted, answer.stamp.sec > 1700000000, flush=True)
        return list(ids[answer.number])

    def result(goal):
        answer = results.ask(lambda n: GetResult(GUID, n, goal), patience=3.0)
        print("result", answer.status, answer.epoch, answer.id, answer.end, answer.code, answer.text, flush=True)

    goal = begin("clamp", 5)
    result(goal)
    heard = {f.operation for f in feedback.take(20) if list(f.goal_id) == goal}
    print("feedback", sorted(heard), flush=True)
    goal = begin("hold", 6)
    answer = cancels.ask(lambda n: Cancel(GUID, n, GoalInfo(goal, Time(0, 0))))
    print("cancelled", answer.return_code, [list(info.goal_id) == goal for info in answer.goals_canceling], flush=True)
    result(goal)
    time.sleep(0.3)
    latest = status.take(20)[-1].status_list
    print("status", [s.status for s in latest if list(s.goal_info.goal_id) == goal], flush=True)


main()
