"""Parts of the Rerun view: colours by the friction cone, applied wrenches, thinning, bulk decoding."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rb_physics as rb
from rb_physics.recording import Recorder, decoders, encoders
from rb_physics.recording.geometry import describe, from_json, to_json
from rb_physics.recording.operations import Operation
from rb_physics.recording.outputs import CONTACT_POINT
from rb_physics.recording.palette import CONE, ForceArrows, cone_colors
from rb_physics.recording.render import write_rrd

rr = pytest.importorskip("rerun")


class Sent:
    """Stands for Rerun's recording stream: remembers what was sent."""

    def __init__(self) -> None:
        self.columns: dict[str, list] = {}

    def log(self, *_args, **_named) -> None:
        pass

    def send_columns(self, entity, indexes, columns) -> None:
        self.columns.setdefault(entity, []).append((indexes, columns))


def test_cone_colors_end_at_slipping():
    colors = cone_colors(np.array([0.0, 0.5, 1.0, 1.7]))
    assert colors[0].tolist() == list(CONE[0])
    assert colors[2].tolist() == colors[3].tolist() == list(CONE[-1])
    # 255 steps over two spans of at most 225: half of the table is at most one step off.
    assert np.abs(colors[1].astype(int) - CONE[1]).max() <= 1


@pytest.mark.parametrize("combine", ["geometric_mean", "mean", "min", "max", "product"])
def test_share_of_the_cone_is_that_of_the_worlds_friction(combine):
    from rb_physics.recording.rerun_contacts import ContactEntities

    world = rb.World(friction_combine=combine)
    world.add_body(rb.HalfSpace(), type="static", name="ground", friction=0.8)
    box = world.add_body(
        rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.1), name="box", friction=0.45
    )
    mu = {"geometric_mean": math.sqrt(0.36), "mean": 0.625, "min": 0.45, "max": 0.8,
          "product": 0.36}[combine]  # fmt: skip
    box.apply_wrench((0.7 * mu * 9.81, 0, 0), (0, 0, 0))  # 70 % of what friction can hold
    world.step(200)
    bodies = from_json(to_json(describe(world.bodies)))
    entities = ContactEntities(Sent(), bodies, ForceArrows(1.0, 1.0), combine, 10)
    from rb_physics.recording.outputs import contact_points

    points = contact_points(world.contacts)
    forces = np.stack([points["fx"], points["fy"], points["fz"]], axis=-1)
    # The four corners may share friction otherwise than weight; together they use 70 %.
    total = forces.sum(axis=0, keepdims=True)
    one = points[:1].copy()
    [color] = entities.colors(one, total.astype(np.float32))
    expected = cone_colors(np.array([0.7]))[0].astype(int)
    # Colours are a table of 256: one step is at most 2 of 255.
    assert np.abs(color.astype(int) - expected).max() <= 2


def test_many_wrenches_in_one_operation_have_an_arrow_each():
    from rb_physics.recording.rerun_applied import AppliedWrenches

    world = rb.World()
    for name in ("a", "b"):
        world.add_body(rb.Sphere(0.1), mass=1.0, name=name)
    sent = Sent()
    applied = AppliedWrenches(sent, describe(world.bodies), ForceArrows(1.0, 1e9), 1)
    poses = np.array([[0, 0, 1, 0, 0, 0, 1], [5, 0, 0, 0, 0, 0, 1]], float)
    rows = [[1, 0, 0, 0, 0, 0], [0, 2, 0, 0, 0, 3]]
    arguments = {"bodies": ["a", "b"], "sources": [1, 1], "wrenches": rows, "frame": "world",
                 "duration": None}  # fmt: skip
    applied.take(0, Operation(0, "apply_wrenches", arguments), poses)
    applied.add(10, poses)
    assert lengths(sent, "world/applied_forces") == [2]
    assert lengths(sent, "world/applied_torques") == [1]
    applied.take(20, Operation(0, "clear_wrenches", {"body": "a"}), poses)
    applied.add(30, poses)
    assert lengths(sent, "world/applied_forces") == [2, 1]
    # Body a goes: what acts on b stays.
    fewer = AppliedWrenches(sent, describe(world.bodies)[1:], ForceArrows(1.0, 1e9), 1, applied)
    fewer.add(40, poses[1:])
    assert lengths(sent, "world/applied_forces") == [2, 1, 1]


def lengths(sent: Sent, entity: str) -> list[int]:
    """Arrows of every sample."""
    counts = []
    for _, columns in sent.columns[entity]:
        arrays = {c.component_descriptor().component: c.as_arrow_array() for c in columns}
        [vectors] = [array for name, array in arrays.items() if name.endswith("vectors")]
        counts += [len(cell) for cell in vectors.to_pylist()]
    return counts


def test_messages_alike_are_decoded_at_once_and_others_one_by_one():
    def decode(data):
        return np.array(decoders.decode_wrench_stamped(data).values)

    rng = np.random.default_rng(3)
    values = rng.normal(size=(20, 6))
    encoder = encoders.WrenchStampedEncoder(["body/com"])
    messages = [encoder.encode(k * 10**7, row[None])[0] for k, row in enumerate(values)]
    assert np.array_equal(decoders.stack_doubles(messages, decode, True), values)
    other = encoders.WrenchStampedEncoder(["b"]).encode(5, values[:1])[0]
    mixed = decoders.stack_doubles([*messages, other], decode, True)
    assert np.array_equal(mixed, np.vstack((values, values[:1])))
    padded = [message + bytes(3) for message in messages]  # legal: the numbers aren't at the end
    assert np.array_equal(decoders.stack_doubles(padded, decode, True), values)


def test_point_clouds_are_the_same_with_and_without_the_quick_way():
    rng = np.random.default_rng(4)
    decoder = decoders.PointCloudDecoder()
    for count in (3, 0, 7, 1):
        points = np.zeros(count, CONTACT_POINT)
        points["fx"] = rng.normal(size=count)
        points["kind"] = 2
        for frame in ("world", "world", "elsewhere"):
            data = encoders.PointCloudEncoder(frame, CONTACT_POINT).encode(1_500_000_000, points)
            quick, slow = decoder(data), decoders.decode_point_cloud(data)
            assert quick[:2] == slow[:2] == (1_500_000_000, frame)
            assert quick[2].tobytes() == slow[2].tobytes() == points.tobytes()
            for end in range(len(data)):
                with pytest.raises(ValueError, match=r"ends|bytes|points"):
                    decoder(data[:end])


def test_view_follows_bodies_that_come_and_go(tmp_path):
    rr.set_strict_mode(True)
    try:
        scene = rb.load_scene("demo")
        world = scene.build()
        with Recorder(world, tmp_path / "run", scene=scene, rerun="file") as recorder:
            for step in range(120):
                if step == 40:
                    recorder.perform("add_body", description={
                        "name": "guest", "shape": {"type": "sphere", "radius": 0.1}, "mass": 1.0,
                        "position": [0.5, 0.5, 2.0]})  # fmt: skip
                    recorder.perform("apply_wrench", body="guest", force=(1, 0, 0))
                if step == 80:
                    recorder.perform("remove_body", body="guest")
                world.step()
                recorder.after_step()
        assert recorder.view_error is None
        again = write_rrd(tmp_path / "run", tmp_path / "again.rrd")
    finally:
        rr.set_strict_mode(False)
    from rerun.chunk import RrdReader

    for path in (tmp_path / "run" / "run.rrd", again):
        entities = {str(chunk.entity_path) for chunk in RrdReader(str(path)).stream()}
        assert {"/world/bodies/guest", "/plots/contact_force/guest"} <= entities


def test_a_branch_shows_the_wrenches_that_act_already_at_its_start(tmp_path):
    """One for ever, one about to end, one that has ended, one cleared; a branch of the branch, too."""
    from rb_physics.recording.branch import branch
    from rb_physics.recording.replay import verify

    scene = rb.Scene.from_yaml(
        "bodies: [{name: a, mass: 1, shape: {type: sphere, radius: 0.1}, center_of_mass: [0, 0, 0.05]}]"
    )
    world = scene.build()
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        for step in range(200):
            for source, (at, duration) in enumerate(
                ((10, None), (20, 0.1), (30, 0.01), (40, None))
            ):
                if step == at:
                    recorder.perform("apply_wrench", body="a", force=(1, source, 0), frame="body",
                                     point=(0, 0, 0.1), duration=duration, source=source)  # fmt: skip
            if step == 50:
                recorder.perform("clear_wrenches", body="a", source=3)
            world.step()
            recorder.after_step()
    branch(tmp_path / "run", tmp_path / "one", 0.06, 0.16, rerun="off")
    branch(tmp_path / "one", tmp_path / "two", 0.08, 0.16, rerun="off")
    for name, until in (("one", 0.12), ("two", 0.12)):
        assert verify(tmp_path / name).difference is None
        pushed = arrows(write_rrd(tmp_path / name, tmp_path / f"{name}.rrd"))
        times = sorted(pushed)
        assert all(len(pushed[time]) == 2 for time in times if time <= until), pushed
        assert all(len(pushed[time]) == 1 for time in times if time > until + 0.001), pushed
        direction = {round(float(v[1] / v[0])) for v in pushed[times[1]]}
        assert direction == {0, 1}


def arrows(path) -> dict[float, list]:
    """Vectors of the applied forces by time, s."""
    from rerun.chunk import RrdReader

    found = {}
    for chunk in RrdReader(str(path)).stream():
        batch = chunk.to_record_batch()
        if str(chunk.entity_path) == "/world/applied_forces" and "sim_time" in batch.schema.names:
            [name] = [n for n in batch.schema.names if "vectors" in n]
            stamps = batch.column("sim_time").cast("int64").to_numpy()
            for time, cell in zip(stamps, batch.column(name).to_pylist(), strict=True):
                found[time * 1e-9] = cell or []
    return found
