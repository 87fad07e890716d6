"""sim_node as a lifecycle node: unconfigured, inactive, active, and back."""

from geometry_msgs.msg import PoseArray
from harness import wait_for
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger


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
