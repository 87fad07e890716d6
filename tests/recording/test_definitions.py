"""The shipped definitions equal those of the installed message packages."""

from __future__ import annotations

import json
import re

import pytest

from rb_physics.recording import definitions
from rb_physics.resources import shared_folder


def installed() -> bool:
    try:
        definitions.installed_hash("std_msgs/msg/String")
    except LookupError:
        return False
    return True


@pytest.mark.skipif(not installed(), reason="ROS message packages are not installed")
def test_table_equals_the_installed_packages():
    assert definitions.make_table() == definitions._table()


@pytest.mark.skipif(not installed(), reason="ROS message packages are not installed")
@pytest.mark.parametrize(
    "name", ["geometry_msgs/msg/TransformStamped", "visualization_msgs/msg/MarkerArray"]
)
def test_hash_of_a_description_equals_the_installed_hash(name):
    path = definitions._installed_file(name, ".json")
    description = json.loads(path.read_text())["type_description_msg"]
    assert definitions.type_description_hash(description) == definitions.installed_hash(name)


def test_text_holds_each_dependency_once_and_sorted():
    text = definitions.definition("geometry_msgs/msg/PoseArray").text
    names = [line[5:] for line in text.splitlines() if line.startswith("MSG: ")]
    assert names == [
        "builtin_interfaces/Time",
        "geometry_msgs/Point",
        "geometry_msgs/Pose",
        "geometry_msgs/Quaternion",
        "std_msgs/Header",
    ]
    assert text.startswith("std_msgs/Header header\nPose[] poses\n")


@pytest.mark.parametrize("name", ["nonsense", "no_such_msgs/msg/Thing", "std_srvs/srv/Trigger"])
def test_unknown_types_say_so(name):
    with pytest.raises(LookupError, match=r"not known|not a message type"):
        definitions.definition(name)


def test_every_type_of_the_packaged_topics_is_in_the_table():
    """Recording needs no ROS: nothing may be looked up among installed packages."""
    topics = (shared_folder("msg_configs") / "topics.yaml").read_text(encoding="utf-8")
    types = set(re.findall(r"type: (\w+/msg/\w+)", topics))
    assert len(types) > 10
    assert types <= set(definitions._table())
