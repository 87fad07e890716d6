"""In an island of more than 400 contact points the gaps were forgotten once anything rebounded:
balls went 28 mm into each other and were thrown apart with 24 J.
"""

import numpy as np

import rb_physics as rb


def test_balls_that_bounce_in_a_bin_keep_apart_and_gain_nothing():
    rng = np.random.default_rng(0)
    world = rb.World(dt=5e-3)
    n, surface = 7, {"restitution": 0.5, "friction": 0.3}
    for normal in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)):
        world.add_body(rb.HalfSpace(normal, -0.101 * n), type="static", **surface)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", **surface)
    for i, j, k in np.ndindex(n, n, n):
        x, y = 0.2 * (np.array((i, j)) - (n - 1) / 2) + rng.uniform(-1e-3, 1e-3, 2)
        world.add_body(
            rb.Sphere(0.1),
            mass=1.0,
            position=(x, y, 0.105 + 0.205 * k),
            linear_velocity=(0, 0, -1.0),
            **surface,
        )
    energy = world.kinetic_energy + world.potential_energy
    most = 0
    for _ in range(30):
        world.step()
        before, energy = energy, world.kinetic_energy + world.potential_energy
        assert energy <= before * (1 + 1e-12)  # rounding of the sums
        # Gaps are linear in a step; 1e-5 of a ball's size.
        assert world.stats.max_penetration <= 1e-6
        most = max(most, world.stats.contacts)
    assert most > 400
