"""Bodies that are added, removed and changed while the node runs; the recording repeats it all."""

import json

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import inputs_status, operations_on, wait_for
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from rb_physics.recording.replay import verify

BALL = "{name: ball, shape: {type: sphere, radius: 0.1}, mass: 3, position: [1, 0, 0.1]}"


class Bodies:
    """Topics of a running simulator through which bodies come and go."""

    def __init__(self, sim):
        self.client = sim.client
        topics = {name: f"/sim_node/{name}" for name in ("spawn", "remove", "change")}
        self._publishers = {n: sim.client.publisher(String, t) for n, t in topics.items()}
        self._names = sim.client.collect(String, "/sim_node/body_names", latched=True)
        self.operations = sim.client.collect(String, "/sim_node/operations")

    def send(self, what, text):
        self._publishers[what].publish(String(data=text))

    def wait_for_names(self, *names):
        wait_for(
            lambda: self._names and json.loads(self._names[-1].data) == list(names),
            f"the bodies {names}",
        )


def test_a_spawned_body_has_topics_and_weight_and_can_be_pushed_and_removed(simulator):
    sim = simulator()
    bodies = Bodies(sim)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    bodies.send("spawn", BALL)
    bodies.wait_for_names("ground", "crate", "floater", "ball")
    wrenches = sim.client.collect(WrenchStamped, "/sim_node/bodies/ball/contact_wrench")
    # 3 kg at rest under 10 m/s²; 1e-9: the solver's residual
    wait_for(lambda: wrenches and abs(wrenches[-1].wrench.force.z - 30.0) < 1e-9, "its weight")
    assert wrenches[-1].header.frame_id == "ball/com"
    publisher = sim.client.publisher(WrenchStamped, "/sim_node/bodies/ball/wrench")
    message = WrenchStamped()
    message.header.frame_id = "ball/com"
    message.wrench.force.z = 200.0
    publisher.publish(message)
    wait_for(lambda: len(poses[-1].poses) == 4 and poses[-1].poses[3].position.z > 0.3, "a jump")
    bodies.send("remove", "ball")
    bodies.wait_for_names("ground", "crate", "floater")
    wait_for(lambda: len(poses[-1].poses) == 3, "poses without it")
    topic = "/sim_node/bodies/ball/wrench"
    wait_for(lambda: sim.client.node.count_subscribers(topic) == 0, "its topic to go")
    bodies.send("spawn", BALL)  # the name is free again
    bodies.wait_for_names("ground", "crate", "floater", "ball")
    again = sim.client.collect(WrenchStamped, "/sim_node/bodies/ball/contact_wrench")
    wait_for(lambda: again and abs(again[-1].wrench.force.z - 30.0) < 1e-9, "its weight")


def test_a_change_acts_and_is_echoed(simulator):
    sim = simulator()
    bodies = Bodies(sim)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    bodies.send(
        "change", "{name: crate, friction: 0, position: [5, 0, 0.1], linear_velocity: [1, 0, 0]}"
    )
    (done,) = wait_for(lambda: operations_on(bodies.operations, "change_body"), "the change")
    assert done["arguments"]["friction"] == 0
    # Without friction it slides on at 1 m/s.
    wait_for(lambda: poses and poses[-1].poses[1].position.x > 6.0, "it to slide a metre")


@pytest.mark.parametrize(
    ("topic", "text", "words"),
    [
        ("spawn", BALL.replace("ball", "crate"), "'crate' is already taken"),
        ("spawn", BALL.replace("mass: 3", "mass: -3"), "mass is -3; it must be greater than 0"),
        ("spawn", BALL.replace("ball", "world"), "not 'world'"),
        ("spawn", BALL.replace(", mass: 3", ""), "exactly one"),
        ("spawn", "{name: ball", "not valid YAML"),
        ("spawn", "", "empty"),
        ("spawn", "<robot name='9'><link name='a'/></robot>", "no link has a collision"),
        ("spawn", BALL.replace("0.1}", ".nan}"), "must be a finite number"),
        ("remove", "nobody", "no body 'nobody'; there are ground, crate, floater"),
        ("change", "{name: nobody, friction: 1}", "no body 'nobody'"),
        ("change", "{name: crate}", "nothing to change"),
        ("change", "{name: crate, mass: 2}", "unknown key mass; allowed are name, position"),
        ("change", "{name: crate, friction: -1}", "friction is -1"),
        ("change", "{name: crate, orientation: [0, 0, 0, 2]}", "unit quaternion"),
        ("change", "{name: ground, linear_velocity: [1, 0, 0]}", "is static"),
    ],
)
def test_what_is_refused(simulator, topic, text, words):
    sim = simulator()
    bodies = Bodies(sim)
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    bodies.send(topic, text)
    wait_for(lambda: words in sim.node.output, f"a line with {words!r}; it said {sim.node.output}")
    wait_for(lambda: inputs_status(diagnostics).get("refused_body") == 1, "the refusal counted")
    assert bodies.operations == []


URDF = """<robot name="ball"><link name="l">
<inertial><mass value="3"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>"""


def test_services_do_the_same_with_an_answer(simulator):
    sim = simulator(start_paused=True)
    names = sim.client.collect(String, "/sim_node/body_names", latched=True)

    def call(service, text):
        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
        request = SetParameters.Request(parameters=[Parameter(name="body", value=value)])
        (result,) = sim.client.call(SetParameters, "/sim_node/set_parameters", request).results
        assert result.successful, result.reason
        answer = sim.client.call(Trigger, f"/sim_node/{service}")
        return answer.success, answer.message

    def bodies():
        return json.loads(names[-1].data)

    assert call("spawn", BALL) == (True, "done before step 1")
    wait_for(lambda: names and bodies() == ["ground", "crate", "floater", "ball"], "the ball")
    taken = call("spawn", BALL)
    assert taken == (False, "no body added: body name 'ball' is already taken; names are unique")
    assert call("change", "{name: ball, friction: 0.1}") == (True, "done before step 1")
    wrong = call("change", "{name: ball, friction: -1}")
    assert not wrong[0] and "friction is -1" in wrong[1]
    assert call("remove", "ball") == (True, "done before step 1")
    gone = call("remove", "ball")
    assert gone == (
        False,
        "~/remove refused: there is no body 'ball'; there are ground, crate, floater",
    )
    assert sim.client.call(Trigger, "/sim_node/step").success
    assert call("spawn", URDF) == (True, "done before step 2")
    wait_for(lambda: bodies()[-1] == "ball", "the ball described as URDF")
    refused = call("spawn", "<sdf/>")
    assert not refused[0] and "of XML only URDF" in refused[1]
    assert call("spawn", "")[0] is False


def test_a_run_in_which_bodies_come_and_go_verifies(simulator, tmp_path):
    sim = simulator(record_dir=tmp_path / "runs", step_count=40, start_paused=True)
    bodies, client = Bodies(sim), sim.client
    steps = 0

    def step():
        nonlocal steps
        assert client.call(Trigger, "/sim_node/step").success
        steps += 40

    def order(what, text, *names):
        bodies.send(what, text)
        bodies.wait_for_names(*names)
        step()

    step()
    first = ("ground", "crate", "floater")
    order("spawn", BALL, *first, "ball")
    push = client.publisher(WrenchStamped, "/sim_node/bodies/ball/wrench")
    message = WrenchStamped()
    message.header.frame_id = "ball"
    message.wrench.force.x = -40.0
    push.publish(message)
    while not operations_on(bodies.operations, "apply_wrench"):  # it acts once it has arrived
        step()
    order("remove", "crate", "ground", "floater", "ball")
    bodies.send(
        "change", "{name: ball, friction: 0.1, restitution: 0.5, linear_velocity: [0, 1, 2]}"
    )
    wait_for(lambda: operations_on(bodies.operations, "change_body"), "the change")
    step()
    order("spawn", BALL.replace("ball", "second"), "ground", "floater", "ball", "second")
    assert client.call(Trigger, "/sim_node/reset_state").success
    resets = [steps]
    bodies.wait_for_names(*first)
    step()
    order("spawn", BALL.replace("ball", "third"), *first, "third")
    assert client.call(Trigger, "/sim_node/reset").success
    resets.append(steps)
    bodies.wait_for_names(*first)
    step()
    order("spawn", BALL, *first, "ball")
    assert client.call(SetBool, "/sim_node/pause", SetBool.Request(data=True)).success
    assert sim.node.stop() == 0
    (run,) = (tmp_path / "runs").iterdir()
    verification = verify(run)
    assert verification.difference is None
    assert verification.steps == steps
    # The echo counts as the log does, through resets.
    echoed = [json.loads(message.data) for message in bodies.operations]
    assert [op["step"] for op in echoed if op["name"] in ("reset", "reset_state")] == resets
    assert (echoed[-1]["name"], echoed[-1]["step"]) == ("add_body", steps - 40)


@pytest.mark.parametrize("by_service", [False, True])
def test_a_name_too_long_for_a_topic_is_refused_and_the_node_goes_on(simulator, by_service):
    sim = simulator()
    text = f"{{name: {'a' * 230}, shape: {{type: sphere, radius: 0.1}}, mass: 1}}"
    words = "ROS takes 247: choose a shorter one"
    if by_service:
        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
        request = SetParameters.Request(parameters=[Parameter(name="body", value=value)])
        sim.client.call(SetParameters, "/sim_node/set_parameters", request)
        answer = sim.client.call(Trigger, "/sim_node/spawn")
        assert not answer.success
        assert words in answer.message
    else:
        sim.client.publisher(String, "/sim_node/spawn").publish(String(data=text))
        wait_for(lambda: words in sim.node.output, "the refusal")
    assert sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=True)).success
    assert sim.node.stop() == 0
