"""A process without ROS: Cyclone DDS publishes a wrench and watches the poses (JSON on stdout).

Arguments: wrench topic, pose topic (DDS names such as rt/sim_node/poses), row, seconds.
"""

import json
import os
import sys
import time

from cyclone_messages import Header, PoseArray, Time, Vector3, Wrench, WrenchStamped
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


def main() -> None:
    wrench_topic, pose_topic, row, limit = *sys.argv[1:3], int(sys.argv[3]), float(sys.argv[4])
    reliable = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
    participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
    writer = DataWriter(participant, Topic(participant, wrench_topic, WrenchStamped), qos=reliable)
    reader = DataReader(participant, Topic(participant, pose_topic, PoseArray), qos=reliable)
    message = WrenchStamped(
        Header(Time(0, 0), "world"), Wrench(Vector3(20.0, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
    )
    first = last = None
    end = time.monotonic() + limit
    while time.monotonic() < end:
        for sample in reader.take(100):
            last = sample.poses[row].position.x
            first = last if first is None else first
        if first is not None:
            writer.write(message)
            if abs(last - first) > 0.1:
                break
        time.sleep(0.02)
    print(json.dumps({"first": first, "last": last}))


if __name__ == "__main__":
    main()
