"""A world restored into a freshly built one parted from the original when its warm start was first
refused: the line search for the least impulses began with memory of an earlier solve."""

import rb_physics as rb


def build() -> rb.World:
    world = rb.World(dt=2e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static")
    for k in range(3):
        position = (0, 0, 0.1 + 0.2 * k)
        world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=2.0, position=position, name=f"box{k}")
    return world


def test_restored_world_repeats_the_original() -> None:
    original, restored = build(), build()
    original.step(50)
    restored.restore(original.save())
    for step in range(40):
        if step in (10, 25):
            for world in (original, restored):
                world["box0"].apply_wrench(force=(0.0, 2.0 if step == 10 else 0.0, 0.0))
        original.step()
        restored.step()
        assert original.state_hash == restored.state_hash, f"step {step}"
