"""The services of simulation_interfaces, called with stand-ins for its messages.

The package is not among the ROS wheels. The stand-ins have the fields and constants of version 1.5
that the node uses, with the defaults that generated messages have.
"""

import math
import threading
from types import SimpleNamespace

import pytest
from geometry_msgs.msg import Pose, PoseStamped, Twist, Vector3
from rb_physics_nodes.inputs import Inputs
from rb_physics_nodes.pacer import Pacer
from rb_physics_nodes.physics_loop import PhysicsLoop
from rb_physics_nodes.simulation_interfaces import OFFERED, SERVICES, SimulationInterfaces
from std_msgs.msg import Header

import rb_physics as rb
from rb_physics.recording import Recorder


def message(name, constants=(), /, **fields):
    """A class whose instances have `fields` (name=factory) and whose constants are `constants`."""

    def __init__(self, **given):
        for field, factory in fields.items():
            setattr(self, field, given.pop(field) if field in given else factory())
        assert not given, f"{name} has no {given}"

    return type(name, (), {"__init__": __init__, **dict(constants)})


FEATURES = {name: number for number, name in enumerate(OFFERED, start=10)}
Result = message(
    "Result",
    {"RESULT_FEATURE_UNSUPPORTED": 0, "RESULT_OK": 1, "RESULT_NOT_FOUND": 2,
     "RESULT_INCORRECT_STATE": 3, "RESULT_OPERATION_FAILED": 4},
    result=int, error_message=str,
)  # fmt: skip
SimulationState = message(
    "SimulationState",
    {"STATE_STOPPED": 0, "STATE_PLAYING": 1, "STATE_PAUSED": 2, "STATE_QUITTING": 3,
     "STATE_NO_WORLD": 4, "STATE_LOADING_WORLD": 5},
    state=int,
)  # fmt: skip
EntityCategory = message(
    "EntityCategory",
    {"CATEGORY_OBJECT": 0, "CATEGORY_DYNAMIC_OBJECT": 4, "CATEGORY_STATIC_OBJECT": 5},
    category=int,
)
EntityState = message("EntityState", header=Header, pose=Pose, twist=Twist)
Bounds = message(
    "Bounds",
    {"TYPE_EMPTY": 0, "TYPE_BOX": 1, "TYPE_CONVEX_HULL": 2, "TYPE_SPHERE": 3},
    type=int, points=list,
)  # fmt: skip
Tags = message("TagsFilter", tags=list, filter_mode=int)
Filters = message("EntityFilters", filter=str, categories=list, tags=Tags, bounds=Bounds)
Info = message("EntityInfo", category=EntityCategory, description=str, tags=list)
Features = message(
    "SimulatorFeatures", FEATURES, features=list, spawn_formats=list, custom_info=str
)
MSG = SimpleNamespace(
    Result=Result, SimulationState=SimulationState, EntityCategory=EntityCategory,
    EntityState=EntityState, Bounds=Bounds, SimulatorFeatures=Features,
)  # fmt: skip


def service(request=None, constants=(), /, **response):
    return SimpleNamespace(
        Request=request or message("Request"), Response=message("Response", constants, **response)
    )


SRV = SimpleNamespace(
    GetSimulatorFeatures=service(features=Features),
    GetSimulationState=service(state=SimulationState, result=Result),
    SetSimulationState=service(
        message("Request", state=SimulationState),
        {"ALREADY_IN_TARGET_STATE": 101, "STATE_TRANSITION_ERROR": 102, "INCORRECT_TRANSITION": 103},
        result=Result,
    ),
    StepSimulation=service(message("Request", steps=lambda: 1), result=Result),
    ResetSimulation=service(
        message(
            "Request",
            {"SCOPE_DEFAULT": 0, "SCOPE_TIME": 1, "SCOPE_STATE": 2, "SCOPE_SPAWNED": 4,
             "SCOPE_ALL": 255},
            scope=int,
        ),
        result=Result,
    ),
    GetEntities=service(message("Request", filters=Filters), result=Result, entities=list),
    GetEntityState=service(message("Request", entity=str), result=Result, state=EntityState),
    GetEntitiesStates=service(
        message("Request", filters=Filters), result=Result, entities=list, states=list
    ),
    SetEntityState=service(
        message("Request", entity=str, state=EntityState), {"INVALID_POSE": 101}, result=Result
    ),
    GetEntityInfo=service(message("Request", entity=str), result=Result, info=Info),
    GetEntityBounds=service(message("Request", entity=str), result=Result, bounds=Bounds),
    SpawnEntity=service(
        message("Request", name=str, allow_renaming=bool, uri=str, resource_string=str,
                entity_namespace=str, initial_pose=PoseStamped),
        {"NAME_NOT_UNIQUE": 101, "NAME_INVALID": 102, "UNSUPPORTED_FORMAT": 103,
         "NO_RESOURCE": 104, "NAMESPACE_INVALID": 105, "RESOURCE_PARSE_ERROR": 106,
         "MISSING_ASSETS": 107, "UNSUPPORTED_ASSETS": 108, "INVALID_POSE": 109},
        result=Result, entity_name=str,
    ),
    DeleteEntity=service(message("Request", entity=str), result=Result),
)  # fmt: skip


class Quiet:
    """A Sender that sends nothing."""

    def start(self, world):
        pass

    def steps_until_due(self, world):
        return 10

    accepted = lambda self, world, messages: None  # noqa: E731
    stepped = idle = send_until = start

    def flush(self):
        pass


class Simulation:
    """A physics loop in its thread, and the services by name."""

    def __init__(self, scene):
        world = rb.load_scene(scene).build()
        recorder = Recorder(world, None)
        topics = [topic for topic in recorder.outputs.topics if topic.direction == "in"]
        inputs = Inputs(world, topics, 0.1, 0.5, False, lambda key, text: None)
        self.loop = PhysicsLoop(
            world, inputs, Quiet(), Pacer(world.settings.dt, 1.0), recorder.perform,
            paused=True, duration=0.0, log=print, save=str, spawned=lambda: recorder.spawned,
        )  # fmt: skip
        self.services = SimulationInterfaces(self.loop, recorder.perform, MSG, SRV)
        self._thread = threading.Thread(target=self.loop.run)
        self._thread.start()

    def call(self, service_name, method, **request):
        kind = getattr(SRV, service_name)
        return getattr(self.services, method)(kind.Request(**request), kind.Response())

    def close(self):
        self.loop.stop()
        self._thread.join()


@pytest.fixture
def simulation(scene):
    simulation = Simulation(scene)
    yield simulation
    simulation.close()


def state_of(simulation, name):
    return simulation.call("GetEntityState", "get_entity_state", entity=name)


def set_state(simulation, state):
    wanted = SimulationState(state=state)
    return simulation.call("SetSimulationState", "set_simulation_state", state=wanted).result


def current(simulation):
    return simulation.call("GetSimulationState", "get_simulation_state").state.state


def test_offered_features_are_those_of_the_services(simulation):
    answer = simulation.call("GetSimulatorFeatures", "get_simulator_features")
    assert answer.features.features == list(FEATURES.values())
    assert set(vars(SRV)) == set(SERVICES)


def test_states_and_their_transitions(simulation):
    assert current(simulation) == SimulationState.STATE_PAUSED
    assert set_state(simulation, SimulationState.STATE_PAUSED).result == 101
    assert set_state(simulation, SimulationState.STATE_PLAYING).result == Result.RESULT_OK
    assert current(simulation) == SimulationState.STATE_PLAYING
    assert set_state(simulation, SimulationState.STATE_STOPPED).result == Result.RESULT_OK
    assert current(simulation) == SimulationState.STATE_STOPPED
    assert simulation.loop.step == 0
    assert set_state(simulation, SimulationState.STATE_LOADING_WORLD).result == 103
    assert set_state(simulation, SimulationState.STATE_QUITTING).result == Result.RESULT_OK
    assert simulation.loop.finished.is_set()


def test_stepping_works_while_paused_only(simulation):
    done = simulation.call("StepSimulation", "step_simulation", steps=25).result
    assert done.result == Result.RESULT_OK
    assert simulation.loop.step == 25
    none = simulation.call("StepSimulation", "step_simulation", steps=0).result
    assert none.result == Result.RESULT_OPERATION_FAILED
    set_state(simulation, SimulationState.STATE_PLAYING)
    running = simulation.call("StepSimulation", "step_simulation").result
    assert running.result == Result.RESULT_OPERATION_FAILED
    assert "only while paused" in running.error_message


@pytest.mark.parametrize(
    ("scope", "step", "result"),
    [(0, 0, 1), (255, 0, 1), (3, 0, 1), (2, 30, 1), (1, 0, 1), (4, 30, 1)],
)
def test_reset_scopes(simulation, scope, step, result):
    simulation.call("StepSimulation", "step_simulation", steps=30)
    answer = simulation.call("ResetSimulation", "reset_simulation", scope=scope).result
    assert answer.result == result
    assert simulation.loop.step == step
    moved = simulation.loop.world["floater"].position[2] != 5000.0
    assert moved == (scope in (1, 4))


def test_entities_are_the_bodies_and_can_be_filtered(simulation):
    def entities(**filters):
        return simulation.call("GetEntities", "get_entities", filters=Filters(**filters))

    assert entities().entities == ["ground", "crate", "floater"]
    assert entities(filter="^c").entities == ["crate"]
    assert entities(filter="^[[:alpha:]]{5,6}$").entities == ["ground", "crate"]
    dynamic = EntityCategory(category=EntityCategory.CATEGORY_DYNAMIC_OBJECT)
    assert entities(categories=[dynamic]).entities == ["crate", "floater"]
    assert entities(tags=Tags(tags=["red"])).entities == []
    assert entities(filter="(").result.result == Result.RESULT_OPERATION_FAILED
    info = simulation.call("GetEntityInfo", "get_entity_info", entity="ground").info
    assert info.category.category == EntityCategory.CATEGORY_STATIC_OBJECT


def test_bounds_of_entities_and_entities_within_bounds(simulation):
    def bounds(name):
        return simulation.call("GetEntityBounds", "get_entity_bounds", entity=name)

    def xyz(point):
        return point.x, point.y, point.z

    box = bounds("crate").bounds
    assert box.type == Bounds.TYPE_BOX
    assert [xyz(p) for p in box.points] == [(0.1, 0.1, 0.1), (-0.1, -0.1, -0.1)]
    endless = bounds("ground").bounds
    assert (endless.type, endless.points) == (Bounds.TYPE_EMPTY, [])
    assert bounds("nobody").result.result == Result.RESULT_NOT_FOUND

    def inside(kind, *points):
        given = Bounds(type=kind, points=[Vector3(x=x, y=y, z=z) for x, y, z in points])
        return simulation.call("GetEntities", "get_entities", filters=Filters(bounds=given))

    # The crate fills 0 to 0.2 m of the z axis, the floater lies about (3, 0, 5000).
    assert inside(1, (5, 1, 5001), (0.5, -1, 0.1)).entities == ["floater"]
    assert inside(3, (0, 0, 0.35), (0.16, 0, 0)).entities == ["crate"]
    assert inside(3, (0, 0, 0.35), (0.14, 0, 0)).entities == []
    corners = [(x, y, z) for x in (0.0, 0.3) for y in (0.0, 0.3) for z in (-1.0, 1.0)]
    assert inside(2, *corners).entities == ["ground", "crate"]
    for kind, points, words in (
        (3, [(0, 0, 0)], "2 points, not 1"),
        (1, [(0, 0, 0), (0, 0, 0)], "no body"),
        (2, [(0, 0, 0), (1, 0, 0)], "no body"),
        (1, [(math.nan, 0, 0), (1, 1, 1)], "finite"),
        (9, [(0, 0, 0), (1, 1, 1)], "unknown type 9"),
    ):
        refused = inside(kind, *points).result
        assert refused.result == Result.RESULT_OPERATION_FAILED
        assert words in refused.error_message


def test_a_state_that_was_set_is_read_back(simulation):
    state = EntityState()
    state.pose.position.x, state.pose.position.z = 7.0, 9.0
    state.pose.orientation.z = state.pose.orientation.w = math.sqrt(0.5)
    state.twist.linear.y, state.twist.angular.x = 2.0, 3.0
    answer = simulation.call("SetEntityState", "set_entity_state", entity="crate", state=state)
    assert answer.result.result == Result.RESULT_OK, answer.result.error_message
    read = state_of(simulation, "crate").state
    assert read.header.frame_id == "world"
    assert read.pose.position == state.pose.position
    assert read.pose.orientation.z == pytest.approx(math.sqrt(0.5), abs=1e-15)  # normalised
    # ω = J⁻¹ L is derived from the stored angular momentum: rounding
    assert read.twist.linear.y == pytest.approx(2.0, abs=1e-14)
    assert read.twist.angular.x == pytest.approx(3.0, abs=1e-14)
    everyone = simulation.call("GetEntitiesStates", "get_entities_states")
    assert everyone.entities == ["ground", "crate", "floater"]
    assert everyone.states[1].pose.position == state.pose.position


def test_bad_entity_requests_are_answered(simulation):
    unknown = state_of(simulation, "nobody").result
    assert unknown.result == Result.RESULT_NOT_FOUND
    assert "ground, crate, floater" in unknown.error_message

    def put(name, **change):
        state = EntityState()
        for path, value in change.items():
            part = state
            *parents, leaf = path.split("__")
            for parent in parents:
                part = getattr(part, parent)
            setattr(part, leaf, value)
        return simulation.call("SetEntityState", "set_entity_state", entity=name, state=state)

    assert put("crate", pose__position__x=math.nan).result.result == 101
    assert put("crate", pose__orientation__w=0.0).result.result == 101
    moving = put("ground", twist__linear__x=1.0).result
    assert moving.result == Result.RESULT_OPERATION_FAILED
    assert "static" in moving.error_message
    frame = put("crate", header__frame_id="crate/nowhere").result
    assert frame.result == Result.RESULT_OPERATION_FAILED
    assert "there is no frame 'crate/nowhere'" in frame.error_message


URDF = """<robot name="stone"><link name="l">
<inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>"""
MESH = URDF.replace('<sphere radius="0.1"/>', '<mesh filename="no.stl"/>')
ARM = """<robot name="arm"><link name="a"/><link name="b"/><joint name="elbow" type="revolute">
<parent link="a"/><child link="b"/></joint></robot>"""
BALL = "{shape: {type: sphere, radius: 0.1}, mass: 1}"


def spawn(simulation, frame="", x=0.0, **request):
    pose = PoseStamped()
    pose.header.frame_id, pose.pose.position.x = frame, x
    return simulation.call("SpawnEntity", "spawn_entity", initial_pose=pose, **request)


def names(simulation):
    return simulation.call("GetEntities", "get_entities").entities


def test_entities_are_spawned_in_frames_renamed_and_deleted(simulation, tmp_path):
    answer = spawn(simulation, name="ball", resource_string=BALL, x=7.0)
    assert (answer.result.result, answer.entity_name) == (Result.RESULT_OK, "ball")
    assert state_of(simulation, "ball").state.pose.position.x == 7.0
    path = tmp_path / "ball.yaml"
    path.write_text(BALL.replace("mass: 1", "mass: 1, name: ball, position: [0, 0, 2]"))
    answer = spawn(simulation, uri=path.as_uri(), allow_renaming=True, frame="crate/tip", x=1.0)
    assert (answer.result.result, answer.entity_name) == (Result.RESULT_OK, "ball_1")
    position = state_of(simulation, "ball_1").state.pose.position
    # The tip is 0.1 m along x of the crate, which stands at z = 0.1 m; sums of two such numbers
    assert (position.x, position.y, position.z) == pytest.approx((1.1, 0.0, 2.1), abs=1e-15)
    done = simulation.call("DeleteEntity", "delete_entity", entity="ball").result
    assert done.result == Result.RESULT_OK
    assert names(simulation) == ["ground", "crate", "floater", "ball_1"]
    assert simulation.call("ResetSimulation", "reset_simulation", scope=4).result.result == 1
    assert names(simulation) == ["ground", "crate", "floater"]


@pytest.mark.parametrize(
    ("request_fields", "code", "words"),
    [
        ({"name": "crate", "resource_string": BALL}, 101, "'crate' is taken"),
        ({"name": "world", "resource_string": BALL}, 102, "not 'world'"),
        ({"resource_string": BALL}, 106, "name is missing"),
        ({"name": "a", "resource_string": "<sdf/>"}, 103, "only URDF"),
        ({"name": "a", "resource_string": "<robot/>"}, 106, "no link has no parent"),
        ({"name": "a", "resource_string": ARM}, 103, "joint 'elbow' is revolute"),
        ({"name": "9", "resource_string": URDF}, 102, "a letter followed by"),
        ({"name": "a", "resource_string": MESH}, 107, "does not exist"),
        ({"name": "a"}, 104, "neither of uri and resource_string"),
        ({"name": "a", "uri": "/nowhere.yaml"}, 104, "can't be read"),
        ({"name": "a", "uri": "model://x"}, 104, "only paths and file:"),
        ({"name": "a", "resource_string": BALL, "entity_namespace": "n"}, 105, "leave it empty"),
        ({"name": "a", "resource_string": BALL.replace("0.1", "-1")}, 106, "radius is -1"),
        ({"name": "a", "resource_string": BALL, "frame": "map"}, 109, "there is no frame 'map'"),
        ({"name": "a", "resource_string": BALL, "x": math.nan}, 109, "must be finite"),
    ],
)
def test_bad_spawn_requests_are_answered(simulation, request_fields, code, words):
    result = spawn(simulation, **request_fields).result
    assert result.result == code, result.error_message
    assert words in result.error_message
    assert names(simulation) == ["ground", "crate", "floater"]


def test_resets_keep_spawned_bodies_unless_they_are_asked_for(simulation):
    spawn(simulation, name="ball", resource_string=BALL, x=7.0)
    simulation.call("StepSimulation", "step_simulation", steps=30)
    assert simulation.call("ResetSimulation", "reset_simulation", scope=2).result.result == 1
    assert names(simulation) == ["ground", "crate", "floater", "ball"]
    assert state_of(simulation, "ball").state.pose.position.z == 0.0
    assert simulation.loop.step == 30
    assert simulation.call("ResetSimulation", "reset_simulation", scope=255).result.result == 1
    assert names(simulation) == ["ground", "crate", "floater"]
    assert simulation.loop.step == 0
