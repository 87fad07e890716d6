"""A process without ROS: Cyclone DDS drives a kinematic body, feels what it pushes and hears the clock
(JSON on stdout).

Arguments: name of the simulator, body that is driven, its row, seconds.
"""

import json
import os
import sys
import time

from cyclone_messages import (
    Clock,
    Header,
    PoseArray,
    String,
    Time,
    Twist,
    TwistStamped,
    Vector3,
    WrenchStamped,
)
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


def main() -> None:
    simulator, body = f"rt/{sys.argv[1]}", sys.argv[2]
    row, limit = int(sys.argv[3]), float(sys.argv[4])
    reliable = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1000))
    latched = Qos(
        Policy.Reliability.Reliable(duration(seconds=1)),
        Policy.Durability.TransientLocal,
        Policy.History.KeepLast(1),
    )
    participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))

    def reader(name, kind, qos=reliable):
        return DataReader(participant, Topic(participant, name, kind), qos=qos)

    clock, poses = reader("rt/clock", Clock), reader(f"{simulator}/poses", PoseArray)
    names = reader(f"{simulator}/body_names", String, latched)
    wrenches = reader(f"{simulator}/bodies/{body}/contact_wrench", WrenchStamped)
    drive = DataWriter(
        participant,
        Topic(participant, f"{simulator}/bodies/{body}/cmd_vel", TwistStamped),
        qos=reliable,
    )
    motion = Twist(Vector3(0.5, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
    twist = TwistStamped(Header(Time(0, 0), "world"), motion)
    seen = {"names": None, "times": [], "x": [], "forces": []}
    end = time.monotonic() + limit
    while time.monotonic() < end:
        seen["times"] += [s.clock.sec + s.clock.nanosec * 1e-9 for s in clock.take(1000)]
        seen["x"] += [s.poses[row].position.x for s in poses.take(1000)]
        seen["forces"] += [s.wrench.force.x for s in wrenches.take(1000)]
        for sample in names.take(10):
            seen["names"] = json.loads(sample.data)
        if seen["x"] and seen["names"]:
            drive.write(twist)
            if seen["x"][-1] > 0.3:
                break
        time.sleep(0.02)
    print(json.dumps(seen))


if __name__ == "__main__":
    main()
