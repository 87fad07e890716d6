"""A process without ROS: Cyclone DDS calls ~/pause and hears the answers (JSON on stdout).

A service is a pair of topics. Which request an answer belongs to is not in the messages themselves, so that a
caller without ROS sees all answers, but not whose they are. Arguments: node, seconds.
"""

import json
import os
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@final
@dataclass
class Request(IdlStruct, typename="std_srvs::srv::dds_::SetBool_Request_"):
    data: bool


@final
@dataclass
class Response(IdlStruct, typename="std_srvs::srv::dds_::SetBool_Response_"):
    success: bool
    message: str


def main() -> None:
    node, limit = sys.argv[1], float(sys.argv[2])
    reliable = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
    participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
    service = f"{node}/pause"
    writer = DataWriter(participant, Topic(participant, f"rq/{service}Request", Request), reliable)
    reader = DataReader(participant, Topic(participant, f"rr/{service}Reply", Response), reliable)
    end = time.monotonic() + limit
    while time.monotonic() < end and not (
        writer.get_matched_subscriptions() and reader.get_matched_publications()
    ):
        time.sleep(0.02)
    answers = []
    for value in (True, False):
        writer.write(Request(value))
        while time.monotonic() < end:
            taken = reader.take(10)
            if taken:
                answers += [[answer.success, answer.message] for answer in taken]
                break
            time.sleep(0.02)
    print(json.dumps(answers))


if __name__ == "__main__":
    main()
