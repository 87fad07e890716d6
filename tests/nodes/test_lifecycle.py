"""sim_node as a lifecycle node: unconfigured, inactive, active, and back."""

from geometry_msgs.msg import PoseArray
from harness import wait_for
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool, Trigger


def change(sim, transition):
    request = ChangeState.Request(transition=Transition(id=transition))
    return sim.client.call(ChangeState, "/sim_node/change_state", request).success


def state(sim):
    return sim.client.call(GetState, "/sim_node/get_state").current_state.label


def test_configured_activated_deactivated_cleaned_up_and_once_more(simulator, tmp_path):
    sim = simulator(autostart=False, record_dir=tmp_path / "runs")
    assert state(sim) == "unconfigured"
    assert sim.client.node.count_publishers("/clock") == 0

    assert change(sim, Transition.TRANSITION_CONFIGURE)
    clock = sim.client.collect(Clock, "/clock")
    assert state(sim) == "inactive"
    assert change(sim, Transition.TRANSITION_ACTIVATE)
    wait_for(lambda: len(clock) > 20, "time to run")

    assert change(sim, Transition.TRANSITION_DEACTIVATE)
    refused = sim.client.call(Trigger, "/sim_node/step")
    assert (refused.success, refused.message) == (
        False,
        "the node is inactive: activate it first",
    )
    assert change(sim, Transition.TRANSITION_ACTIVATE)
    seen = len(clock)
    wait_for(lambda: len(clock) > seen + 20, "time to go on")
    assert change(sim, Transition.TRANSITION_DEACTIVATE)

    assert change(sim, Transition.TRANSITION_CLEANUP)
    assert state(sim) == "unconfigured"
    wait_for(lambda: sim.client.node.count_publishers("/clock") == 0, "the topics to go")
    (first,) = (tmp_path / "runs").iterdir()
    with AnyReader([first]) as reader:
        assert reader.message_count > 0

    assert change(sim, Transition.TRANSITION_CONFIGURE)
    assert change(sim, Transition.TRANSITION_ACTIVATE)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    wait_for(lambda: poses, "poses of the second run")
    assert len(list((tmp_path / "runs").iterdir())) == 2

    assert change(sim, Transition.TRANSITION_ACTIVE_SHUTDOWN)
    assert sim.node.wait() == 0


def test_a_node_that_cannot_be_configured_says_why_and_stays_unconfigured(simulator, tmp_path):
    sim = simulator(autostart=False, scene=tmp_path / "missing.yaml")
    assert not change(sim, Transition.TRANSITION_CONFIGURE)
    assert state(sim) == "unconfigured"
    assert "missing.yaml does not exist" in sim.node.output


def test_orders_and_parameters_are_answered_before_the_first_activation(simulator):
    sim = simulator(autostart=False)
    assert change(sim, Transition.TRANSITION_CONFIGURE)
    request = SetParameters.Request(
        parameters=[Parameter("wrench_timeout", value=0.5).to_parameter_msg()]
    )
    assert sim.client.call(SetParameters, "/sim_node/set_parameters", request).results[0].successful
    assert sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=True)).success
    assert sim.client.call(Trigger, "/sim_node/reset").success
    refused = sim.client.call(Trigger, "/sim_node/step")
    assert refused.message == "the node is inactive: activate it first"
    going_on = sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=False))
    assert going_on.message == "running at time 0 s, once the node is active"
    clock = sim.client.collect(Clock, "/clock")
    assert change(sim, Transition.TRANSITION_ACTIVATE)
    wait_for(lambda: clock and clock[-1].clock.nanosec > 0, "time to run")
    assert sim.node.stop() == 0


def test_it_ends_at_a_signal_before_the_first_activation(simulator):
    sim = simulator(autostart=False)
    assert change(sim, Transition.TRANSITION_CONFIGURE)
    assert sim.client.call(Trigger, "/sim_node/reset").success
    assert sim.node.stop() == 0


def test_configuring_again_says_why_it_fails(simulator, tmp_path):
    runs = tmp_path / "runs"
    sim = simulator(record_dir=runs)
    wait_for(runs.exists, "the log")
    assert change(sim, Transition.TRANSITION_DEACTIVATE)
    assert change(sim, Transition.TRANSITION_CLEANUP)
    runs.rename(tmp_path / "moved")
    runs.write_text("")
    assert not change(sim, Transition.TRANSITION_CONFIGURE)
    wait_for(lambda: "runs is a file" in sim.node.output, "the reason")
