"""Plots of the accuracy cases: what the bodies do, against the exact curves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

import rb_physics as rb

from .stage import GRAVITY as g
from .stage import rotation, turn


def draw_all(folder: Path) -> Iterator[Path]:
    """Draws every plot into the folder (made if missing); yields the paths. Needs matplotlib."""
    try:
        import matplotlib
    except ImportError as error:
        raise SystemExit("--plots needs matplotlib: pip install 'rb_physics[plot]'") from error
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    folder.mkdir(parents=True, exist_ok=True)
    for draw in (bouncing_ball, slide_to_rest, tumbling, corner_loads):
        figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
        draw(axes)
        axes.grid(alpha=0.3)
        axes.legend(frameon=False)
        path = folder / f"{draw.__name__}.png"
        figure.savefig(path, dpi=110)
        plt.close(figure)
        yield path


def bouncing_ball(axes) -> None:
    """Height over time for several dt, apexes eps^(2k)."""
    radius, restitution = 0.1, 0.8
    for dt in (1e-3, 1e-2, 5e-2):
        world = rb.World(dt=dt)
        world.add_body(
            rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", restitution=restitution
        )
        ball = world.add_body(rb.Sphere(radius), mass=1.0, position=(0, 0, 1 + radius))
        points = [(0.0, 1.0)]
        for _ in range(round(3 / dt)):
            world.step()
            points.append((world.time, ball.position[2] - radius))
        axes.plot(*np.transpose(points), "-" if dt == 1e-3 else ".", ms=3, label=f"dt = {dt:g} s")
    fall = np.sqrt(2 / g)
    for k in range(1, 5):
        t = fall * (1 + 2 * sum(restitution**j for j in range(1, k)) + restitution**k)
        axes.plot(t, restitution ** (2 * k), "k+", label="exact apex" if k == 1 else None)
    axes.set(
        xlabel="t (s)", ylabel="height (m)", title="Ball, ε = 0.8: bounces do not depend on dt"
    )


def slide_to_rest(axes) -> None:
    """Speed over time of a box that slides to rest, and of a sphere that comes to roll."""
    friction, speed = 0.3, 2.0
    for name, shape, z in (
        ("box", rb.Box((0.1, 0.1, 0.02)), 0.02),
        ("sphere", rb.Sphere(0.1), 0.1),
    ):
        world = rb.World(dt=1e-2)
        world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=friction)
        body = world.add_body(
            shape, mass=1.0, position=(0, 0, z), linear_velocity=(speed, 0, 0), friction=friction
        )
        points = [(0.0, speed)]
        for _ in range(100):
            world.step()
            points.append((world.time, body.linear_velocity[0]))
        axes.plot(*np.transpose(points), ".", ms=4, label=f"{name}, dt = 10 ms")
    t = np.linspace(0, 1, 400)
    axes.plot(t, np.maximum(speed - friction * g * t, 0), "k-", lw=0.7, label="exact")
    axes.plot(t, np.maximum(speed - friction * g * t, 5 / 7 * speed), "k-", lw=0.7)
    axes.set(
        xlabel="t (s)", ylabel="speed (m/s)", title="Sliding to rest, and to rolling at 5/7 v₀"
    )


def tumbling(axes) -> None:
    """Spin about the body axes of a body spun about its middle axis."""
    world = rb.World(gravity=(0, 0, 0), dt=1e-2)
    body = world.add_body(
        rb.Sphere(0.3), mass=1.0, inertia=(1, 2, 3), angular_velocity=(0.01, 5, 0.01)
    )
    rows = []
    for _ in range(3000):
        world.step()
        rows.append((world.time, *(rotation(body.orientation).T @ body.angular_velocity)))
    t, *spins = np.transpose(rows)
    for k, spin in enumerate(spins, 1):
        axes.plot(t, spin, lw=1, label=f"ω{'₁₂₃'[k - 1]}")
    axes.set(xlabel="t (s)", ylabel="rad/s", title="Free body, J = (1, 2, 3), dt = 10 ms")


def corner_loads(axes) -> None:
    """Load of the four corners of a box that is pressed down off its middle, then tips over."""
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=1.0)
    half = np.array([0.1, 0.1, 0.3])
    box = world.add_body(
        rb.Box(half),
        mass=1.0,
        position=(0, 0, half[2]),
        friction=1.0,
        orientation=turn((0, 0, 1), 0.0),
    )
    rows = []
    for n in range(400):
        box.apply_wrench(force=(n * 0.02, 0, 0), duration=0)
        world.step()
        loads = np.zeros(2)
        for c in world.contacts:
            loads[int(c["point"][0] > box.position[0])] += c["force"][2]
        rows.append((n * 0.02, *loads))
    push, rear, front = np.transpose(rows)
    axes.plot(push, front, label="front edge")
    axes.plot(push, rear, label="rear edge")
    exact = np.clip(g / 2 - push * half[2] / (2 * half[0]), 0, None)
    axes.plot(push, exact, "k--", lw=0.8, label="lever rule")
    axes.axvline(g * half[0] / half[2], color="k", lw=0.5)
    axes.set(
        xlabel="push at the middle (N)", ylabel="load (N)", title="Load shifts until the box tips"
    )
