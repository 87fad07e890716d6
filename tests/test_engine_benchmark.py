"""The judge of the engine benchmark, and the scenes every engine is given."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.engines.engine_rb_physics import RbPhysics, shape_of
from benchmarks.engines.penetration import separations
from benchmarks.engines.scene import GROUND, Ball, Block, Item, Plane, Scene, plane_frame
from benchmarks.engines.scenes import KINDS, octahedron, prism, scenes

SHAPES = [Block((0.1, 0.2, 0.3)), octahedron(0.2, 0.3, 0.25), prism(0.2, 0.15)]


def random_quaternion(random: np.random.Generator) -> np.ndarray:
    q = random.normal(size=4)
    return q / np.linalg.norm(q)


@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("second", range(3))
def test_separation_of_polytopes_is_what_the_core_says(first: int, second: int) -> None:
    """Overlaps: the depth. Gaps: separating axes give a lower bound, so only the sign."""
    random = np.random.default_rng(3 * first + second)
    overlaps = 0
    for _ in range(30):
        items = [
            Item(SHAPES[k], tuple(random.uniform(-0.22, 0.22, 3)), tuple(random_quaternion(random)))
            for k in (first, second)
        ]
        scene = Scene("two", items, 1e-3, 0, 1, 1, planes=())
        x = np.array([item.position for item in items])
        q = np.array([item.orientation for item in items])
        found = separations(scene, x, q)
        world = rb.World()
        a, b = (
            world.add_body(
                shape_of(i.shape), mass=1.0, position=i.position, orientation=i.orientation
            )
            for i in items
        )
        wanted = rb.distance(a, b).distance
        if wanted < 0:
            overlaps += 1
            assert found == pytest.approx([wanted], abs=1e-9)  # rounding, and hulls' own tolerance
        elif wanted > 1.1e-3:  # else the pair may count as touching
            assert len(found) == 0 or found[0] > 0
    assert overlaps >= 5


def test_separation_of_balls_and_planes() -> None:
    items = [Item(Ball(0.1), (0, 0, 0.09)), Item(Ball(0.2), (0.28, 0, 0.2))]
    wall = Plane((-1.0, 0.0, 0.0), -0.45)
    scene = Scene("balls", items, 1e-3, 0, 1, 1, planes=(GROUND, wall))
    x = np.array([item.position for item in items])
    found = separations(scene, x, np.tile([0, 0, 0, 1.0], (2, 1)))
    between = np.hypot(0.28, 0.11) - 0.3
    # Rounding of numbers below 1.
    assert sorted(found) == pytest.approx([-0.03, -0.01, 0.0, between], abs=1e-15)


def test_planes_have_frames() -> None:
    for normal in ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8)):
        frame = plane_frame(Plane(normal, 0.0))
        # Rounding of products of three numbers below 1.
        assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-15)
        assert np.linalg.det(frame) == pytest.approx(1.0, abs=1e-15)
        assert frame[:, 2] == pytest.approx(normal, abs=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_volume_and_inertia_of_shapes_are_what_the_core_computes(kind: str) -> None:
    for shape in KINDS[kind]:
        body = rb.World().add_body(shape_of(shape), density=1000.0)
        # Rounding of a sum over the faces.
        assert body.mass == pytest.approx(1000.0 * shape.volume, rel=1e-12)
        moments = np.sort(body.mass * np.asarray(shape.principal_inertia))
        assert np.linalg.eigvalsh(body.inertia) == pytest.approx(moments, rel=1e-12)


@pytest.mark.parametrize("name", [name for name in scenes() if not name.endswith("4000")])
def test_nothing_overlaps_at_the_start(name: str) -> None:
    """Else an engine would be judged by what it was given. Heaps may touch the walls they were in."""
    scene = scenes()[name]
    x = np.array([item.position for item in scene.items], float)
    q = np.array([item.orientation for item in scene.items], float)
    inside = Scene(
        name, scene.items, scene.dt, 0, 1, 1, planes=() if "heap" in name else scene.planes
    )
    assert separations(inside, x, q).min(initial=0.0) > -1e-12  # rounding of sums of lengths


def test_our_engine_stands_and_is_judged() -> None:
    scene = scenes()["tower-10"]
    engine = RbPhysics(scene)
    engine.step(3)
    x, q = engine.poses()
    assert x.shape == (10, 3) and q.shape == (10, 4)
    assert separations(scene, x, q).min() > -1e-9  # the tower row of the accuracy table
