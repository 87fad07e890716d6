"""A process without ROS: Cyclone DDS adds a body, pushes it by a batch and removes it (JSON on stdout).

Arguments: name of the simulator, seconds.
"""

import json
import os
import sys
import time

from cyclone_messages import Header, MultiDOFJointState, PoseArray, String, Time, Vector3, Wrench
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


def main() -> None:
    simulator, limit = f"rt/{sys.argv[1]}", float(sys.argv[2])
    reliable = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
    participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))

    def writer(name, kind):
        return DataWriter(
            participant, Topic(participant, f"{simulator}/{name}", kind), qos=reliable
        )

    spawn, remove = writer("spawn", String), writer("remove", String)
    push = writer("wrenches", MultiDOFJointState)
    reader = DataReader(
        participant, Topic(participant, f"{simulator}/poses", PoseArray), qos=reliable
    )
    zero = Vector3(0.0, 0.0, 0.0)
    batch = MultiDOFJointState(
        Header(Time(0, 0), "NAME/com"), ["ball"], [], [], [Wrench(Vector3(20.0, 0.0, 0.0), zero)]
    )
    seen = {"first": None, "spawned": None, "pushed": None, "removed": None}
    end, stage = time.monotonic() + limit, "first"
    while time.monotonic() < end and seen["removed"] is None:
        for sample in reader.take(100):
            count = len(sample.poses)
            if stage == "first":
                seen["first"], stage = count, "spawned"
            elif stage == "spawned" and count > seen["first"]:
                seen["spawned"], stage = count, "pushed"
            elif stage == "pushed" and sample.poses[-1].position.x > 7.1:
                seen["pushed"], stage = sample.poses[-1].position.x, "removed"
            elif stage == "removed" and count < seen["spawned"]:
                seen["removed"] = count
        if stage == "spawned":
            spawn.write(
                String(
                    "{name: ball, shape: {type: sphere, radius: 0.1}, mass: 1, position: [7, 0, 0.1]}"
                )
            )
        elif stage == "pushed":
            push.write(batch)
        elif stage == "removed":
            remove.write(String("ball"))
        time.sleep(0.02)
    print(json.dumps(seen))


if __name__ == "__main__":
    main()
