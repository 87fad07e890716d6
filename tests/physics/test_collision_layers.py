"""Who may touch whom: each one's mask must have a bit of the other's layer."""

import pytest

import rb_physics as rb
from rb_physics.recording.initial_bodies import InitialBodies


def drop(ball: dict, ground: dict) -> rb.World:
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", name="ground", **ground)
    world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 0.15), name="ball", **ball)
    return world


def rests(world: rb.World) -> bool:
    world.step(500)
    z = world["ball"].position[2]
    assert z == pytest.approx(0.1, abs=1e-6) or z < -0.5  # on the ground, or long past it
    return bool(z > 0)


@pytest.mark.parametrize(
    ("ball", "ground", "touch"),
    [
        ({}, {}, True),
        ({"layer": 2}, {}, True),
        ({"layer": 2}, {"mask": 0b101}, False),
        ({"layer": 0b110}, {"mask": 0b101}, True),
        ({"mask": 2}, {}, False),  # the ball does not want the ground, whatever the ground wants
        ({"mask": 2}, {"layer": 0xFFFFFFFF}, True),
        ({"layer": 0}, {}, False),
    ],
)
def test_bodies_touch_when_both_masks_say_so(ball, ground, touch):
    assert rests(drop(ball, ground)) == touch


def test_parts_of_a_compound_share_those_of_the_body():
    world = rb.World(dt=1e-3)
    slab = rb.Compound([(rb.Box((1, 1, 0.1)), (x, 0, -0.1), (0, 0, 0, 1)) for x in (-1, 1)])
    world.add_body(slab, type="static", name="ground", layer=4)
    world.add_body(rb.Sphere(0.1), mass=1.0, position=(0.5, 0, 0.15), name="ball", mask=~4 & 0xFF)
    assert not rests(world)


def test_copies_resets_and_scene_files_keep_them(tmp_path):
    world = drop({"layer": 2, "mask": 8}, {})
    assert not rests(world.copy())
    start = InitialBodies(world)
    world.remove(world["ball"])
    start.put_back()
    assert (world["ball"].layer, world["ball"].mask) == (2, 8)
    path = tmp_path / "scene.yaml"
    path.write_text(
        "bodies:\n- {name: ball, shape: {type: sphere, radius: 1}, mass: 1, layer: 2, mask: 8}\n"
    )
    ball = rb.load_scene(path).build()["ball"]
    assert (ball.layer, ball.mask) == (2, 8)


@pytest.mark.parametrize("field", ["layer", "mask"])
@pytest.mark.parametrize("value", [-1, 2**32, 1.0, True, "all", None])
def test_other_values_are_refused(field, value):
    with pytest.raises(rb.SceneError, match=f"body 'ball': {field} is .*whole number"):
        drop({field: value}, {})
