"""The topics file: what it expands to, and errors that name line and field."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rb_physics.recording.topics import CONTENT, TopicError, load_topics, parse_topics

BODIES = [
    SimpleNamespace(name="ground", type="static"),
    SimpleNamespace(name="box", type="dynamic"),
    SimpleNamespace(name="arm", type="kinematic"),
]


def test_packaged_file_covers_every_content():
    table = load_topics()
    assert {entry.content for entry in table.entries} == set(CONTENT)
    topics = {topic.name: topic for topic in table.expand(BODIES)}
    wrench = topics["/sim_node/bodies/box/contact_wrench"]
    assert (wrench.frame, wrench.body, wrench.rate) == ("box/com", "box", 100.0)
    assert topics["/sim_node/body_names"].qos.durability == "transient_local"
    assert topics["/clock"].type == "rosgraph_msgs/msg/Clock"
    assert "/sim_node/bodies/arm/cmd_pose" in topics
    assert "/sim_node/bodies/box/cmd_pose" not in topics
    assert "/sim_node/bodies/ground/wrench" not in topics


def test_node_name_is_the_namespace():
    names = [topic.name for topic in load_topics().expand(BODIES, "robots/sim")]
    assert "/robots/sim/poses" in names


def entry(**changes) -> str:
    base = {"name": "/clock", "content": "clock", "type": "rosgraph_msgs/msg/Clock",
            "direction": "out"}  # fmt: skip
    fields = {k: v for k, v in (base | changes).items() if v is not None}
    return "# a comment\ntopics:\n  - {" + ", ".join(f"{k}: {v}" for k, v in fields.items()) + "}\n"


POSE = {"name": "~/bodies/NAME/pose", "content": "pose", "type": "geometry_msgs/msg/PoseStamped"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["1", "empty"]),
        ("topics: [}", ["1", "YAML"]),
        ("topic: []", ["1", "topic"]),
        (entry(content="clok"), ["3", "content", "clok", "clock, poses"]),
        (entry(type="std_msgs/msg/String"), ["3", "type", "rosgraph_msgs/msg/Clock"]),
        (entry(direction="in"), ["3", "direction", "clock goes out"]),
        (entry(name="clock"), ["3", "name", "clock"]),
        (entry(name="/clo ck"), ["3", "name"]),
        (entry(rate=-1), ["3", "rate", "-1"]),
        (entry(rate=".inf"), ["3", "rate", "finite"]),
        (entry(rate="fast"), ["3", "rate", "fast"]),
        (entry(colour="red"), ["3", "unknown key colour"]),
        (entry(qoss="{}"), ["3", "did you mean qos?"]),
        (entry(content="clokc"), ["topic /clock: content is 'clokc' (did you mean clock?)"]),
        (entry(**POSE | {"bodies": "[a, a]"}), ["3", "each once"]),
        (entry().replace(", direction", ",\n     direction").replace("out", "in"), [":4: topic"]),
        (entry(type=None), ["3", "type", "required"]),
        (entry(frame="world"), ["3", "frame"]),
        (entry(qos="{depth: 0}"), ["3", "depth", "0"]),
        (entry(qos="{depth: 1000000000}"), ["3", "depth", "at most 100000"]),
        (entry(qos="{reliability: best}"), ["3", "reliability", "best_effort"]),
        (entry(bodies='"*"'), ["3", "bodies", "leave it out"]),
        (entry(**POSE | {"name": "~/pose"}), ["3", "name", "NAME"]),
        (entry(**POSE, frame="NAME"), ["3", "frame", "world"]),
        (entry(**POSE, bodies="some"), ["3", "bodies", "some"]),
    ],
)
def test_errors_name_line_and_field(text, words):
    with pytest.raises(TopicError) as error:
        parse_topics(text, "t.yaml")
    for word in words:
        assert word in str(error.value)


def test_unknown_body_and_double_topic():
    with pytest.raises(TopicError, match=r"t.yaml:3: bodies: there is no body 'crate'.*box"):
        parse_topics(entry(**POSE, bodies="[crate]"), "t.yaml").expand(BODIES)
    twice = entry() + entry().splitlines()[-1]
    with pytest.raises(TopicError, match=r"t.yaml:4: topic /clock is already defined in line 3"):
        parse_topics(twice, "t.yaml").expand(BODIES)


def test_missing_file_says_so(tmp_path):
    with pytest.raises(TopicError, match="can't be read"):
        load_topics(tmp_path / "none.yaml")


@pytest.mark.parametrize(("content", "body"), [("wrench", "ground"), ("cmd_pose", "box")])
def test_inputs_for_bodies_that_cannot_take_them(content, body):
    type_ = "geometry_msgs/msg/" + {"wrench": "WrenchStamped", "cmd_pose": "PoseStamped"}[content]
    given = {"name": "~/bodies/NAME/x", "content": content, "type": type_, "direction": "in"}
    table = parse_topics(entry(**given, bodies=f"[{body}]"), "t.yaml")
    with pytest.raises(
        TopicError, match=rf"t.yaml:3: .* but '{body}' is (static|dynamic): take it"
    ):
        table.expand(BODIES)
    assert table.expand(BODIES, strict=False) == []  # bodies come and go: left out
    # Left out of the file: the bodies that can.
    (topic,) = parse_topics(entry(**given), "t.yaml").expand(BODIES)
    assert topic.body == {"wrench": "box", "cmd_pose": "arm"}[content]
