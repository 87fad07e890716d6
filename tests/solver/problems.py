"""Contact problems from real geometry, as arguments of _core.solver.ContactProblem.

Boxes of half extent `e` (m) and spheres, unit mass unless given, contact normals from B to A.
"""

from __future__ import annotations

import numpy as np

from rb_physics._core import solver

GRAVITY = 9.81


def contact_frame(normal: np.ndarray) -> np.ndarray:
    """Rows n, t1, t2, right-handed."""
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    t1 = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    t1 /= np.linalg.norm(t1)
    return np.array([n, t1, np.cross(n, t1)])


def box_inverse_inertia(mass: float, half_extents) -> np.ndarray:
    h2 = np.asarray(half_extents, float) ** 2
    return np.diag(3.0 / (mass * (h2.sum() - h2)))


class Builder:
    """Collects bodies and contacts; `problem()` makes the ContactProblem."""

    def __init__(self) -> None:
        self.position, self.inv_mass, self.inv_inertia, self.velocity = [], [], [], []
        self.contacts: list[dict] = []

    def body(self, position, mass, inv_inertia, linear=(0, 0, 0), angular=(0, 0, 0)) -> int:
        self.position.append(np.asarray(position, float))
        self.inv_mass.append(1.0 / mass)
        self.inv_inertia.append(np.asarray(inv_inertia, float))
        self.velocity.append(np.concatenate([linear, angular]).astype(float))
        return len(self.inv_mass) - 1

    def contact(self, a: int, b: int, point, normal, **fields) -> None:
        point = np.asarray(point, float)
        self.contacts.append(
            dict(
                bodies=(a, b),
                r_a=point - self.position[a],
                r_b=point - self.position[b] if b >= 0 else np.zeros(3),
                frame=contact_frame(normal),
                **fields,
            )
        )

    def arrays(self) -> dict:
        nc = len(self.contacts)
        out = dict(
            inv_mass=np.array(self.inv_mass),
            inv_inertia=np.array(self.inv_inertia).reshape(-1, 3, 3),
            velocity=np.array(self.velocity).reshape(-1, 6),
            bodies=np.array([c["bodies"] for c in self.contacts], np.int32).reshape(nc, 2),
            frame=np.array([c["frame"] for c in self.contacts]).reshape(nc, 3, 3),
        )
        for name in ("r_a", "r_b", "bias", "angular_bias"):
            out[name] = np.array([c.get(name, np.zeros(3)) for c in self.contacts]).reshape(nc, 3)
        for name in (
            "friction",
            "static_friction",
            "rolling_friction",
            "spinning_friction",
            "restitution",
        ):
            out[name] = np.array([c.get(name, 0.0) for c in self.contacts], float)
        return out

    def problem(self) -> solver.ContactProblem:
        return solver.ContactProblem(**self.arrays())


def tower(count: int, dt: float = 5e-3, friction: float = 0.5, e: float = 0.1) -> Builder:
    """Boxes on boxes on the floor, four points an interface, after one step of gravity."""
    b = Builder()
    for i in range(count):
        z = e * (2 * i + 1)
        b.body((0, 0, z), 1.0, box_inverse_inertia(1.0, (e, e, e)), (0, 0, -GRAVITY * dt))
        for x in (-e, e):
            for y in (-e, e):
                b.contact(i, i - 1, (x, y, z - e), (0, 0, 1), friction=friction)
    return b


def wedge(speed: float, restitution: float = 1.0, walls=(0, 1), mass: float = 2.0) -> Builder:
    """The notes' particle falling into two walls, normals (1, 1)/sqrt 2 and (-2, 1)/sqrt 5."""
    b = Builder()
    b.body((0, 0, 0), mass, np.zeros((3, 3)), (0, -speed, 0))
    for k in walls:
        b.contact(0, -1, (0, 0, 0), ((1, 1, 0), (-2, 1, 0))[k], restitution=restitution)
    return b


def cradle(velocities, restitution: float = 1.0, radius: float = 0.1) -> Builder:
    """Touching equal balls in a row along x."""
    b = Builder()
    for i, v in enumerate(velocities):
        b.body((2 * radius * i, 0, 0), 1.0, np.eye(3) / (0.4 * radius**2), (v, 0, 0))
    for i in range(1, len(velocities)):
        point = (2 * radius * i - radius, 0, 0)
        b.contact(i, i - 1, point, (1, 0, 0), restitution=restitution)
    return b


def billiard_rack(rows: int, speed: float, radius: float = 0.03) -> Builder:
    """Triangle of touching balls in the plane, struck head-on along x by a cue ball (body 0)."""
    b = Builder()
    inertia = np.eye(3) / (0.4 * radius**2)
    b.body((-2 * radius, 0, 0), 1.0, inertia, (speed, 0, 0))
    rack = {}
    for i in range(rows):
        for j in range(i + 1):
            x, y = np.sqrt(3.0) * radius * i, radius * (2 * j - i)
            rack[i, j] = b.body((x, y, 0), 1.0, inertia)
    pairs = [(rack[0, 0], 0)]
    for (i, j), k in rack.items():
        neighbours = [(i, j - 1), (i - 1, j - 1), (i - 1, j)]
        pairs += [(k, rack[n]) for n in neighbours if n in rack]
    for a, c in pairs:
        d = b.position[a] - b.position[c]
        b.contact(a, c, (b.position[a] + b.position[c]) / 2, d, restitution=1.0)
    return b


def random_rotation(rng) -> np.ndarray:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def random_problem(rng: np.random.Generator, friction: float | None = None) -> Builder:
    """A heap of boxes and balls in true contact: faces on the floor and on each other (redundant),
    vertices and balls between; 1 to 60 contacts, friction 0 to 2, mass ratios up to 1e4. Everything
    can part, so that a solution exists (every contact opens for some motion: nothing is wedged in
    by immovable bodies)."""
    b = Builder()
    mu = friction if friction is not None else rng.choice([0.0, rng.uniform(0, 2)], p=[0.2, 0.8])
    wide = rng.uniform() < 0.25  # ill-conditioned: masses over four decades
    lively = rng.uniform(0, 2)
    tops: list[tuple[int, np.ndarray, float, float]] = []  # body, centre of its top, half widths
    contacts = 0
    size = 10 ** rng.uniform(-2, 1)
    for _ in range(rng.integers(1, 13)):
        mass = 10 ** (rng.uniform(-2, 2) if wide else rng.uniform(-0.5, 0.5))
        linear = size * lively * rng.normal(size=3) * (rng.uniform() < 0.3)
        angular = lively * rng.normal(size=3) * (rng.uniform() < 0.3)
        linear[2] -= 0.05 * size
        kind = rng.choice(["box", "ball", "vertex"], p=[0.6, 0.25, 0.15])
        floor = not tops or rng.uniform() < 0.3
        below, top, wx, wy = (
            (-1, np.append(4 * size * rng.normal(size=2), 0.0), 9 * size, 9 * size)
            if floor
            else tops[rng.integers(len(tops))]
        )
        if kind == "box":
            h = size * rng.uniform(0.2, 1.0, 3)
            shift = rng.uniform(-0.5, 0.5, 2) * (wx if not floor else 0, wy if not floor else 0)
            centre = top + np.array([*shift, h[2]])
            k = b.body(centre, mass, box_inverse_inertia(mass, h), linear, angular)
            x = np.clip([centre[0] - h[0], centre[0] + h[0]], top[0] - wx, top[0] + wx)
            y = np.clip([centre[1] - h[1], centre[1] + h[1]], top[1] - wy, top[1] + wy)
            points = [(px, py, top[2]) for px in x for py in y]
            tops.append((k, centre + np.array([0, 0, h[2]]), h[0], h[1]))
            normals = [(0, 0, 1)] * 4
        elif kind == "ball":
            r = size * rng.uniform(0.2, 1.0)
            k = b.body(
                top + np.array([0, 0, r]), mass, np.eye(3) / (0.4 * mass * r * r), linear, angular
            )
            points, normals = [top], [(0, 0, 1)]
            tops.append((k, top + np.array([0, 0, 2 * r]), 0.0, 0.0))
        else:  # a tilted box on one or two of its vertices
            h = size * rng.uniform(0.2, 1.0, 3)
            rot = random_rotation(rng)
            corners = (rot @ (np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, 8).T * h).T).T
            low = corners[np.argmin(corners[:, 2])]
            inverse = rot @ box_inverse_inertia(mass, h) @ rot.T
            k = b.body(top - low, mass, inverse, linear, angular)
            points, normals = [top], [(0, 0, 1)]
        if contacts + len(points) > 60:
            b.position.pop(), b.inv_mass.pop(), b.inv_inertia.pop(), b.velocity.pop()
            break
        for p, n in zip(points, normals, strict=True):
            b.contact(k, below, p, n, friction=mu * rng.choice([1.0, rng.uniform()]))
            contacts += 1
    # The whole world turned: no axis is special.
    turn = random_rotation(rng)
    b.inv_inertia = [turn @ i @ turn.T for i in b.inv_inertia]
    b.velocity = [np.concatenate([turn @ v[:3], turn @ v[3:]]) for v in b.velocity]
    for c in b.contacts:
        c["r_a"], c["r_b"] = turn @ c["r_a"], turn @ c["r_b"]
        c["frame"] = c["frame"] @ turn.T
    return b


def kinetic_energy(arrays: dict, velocity: np.ndarray) -> float:
    energy = 0.0
    for m, i, v in zip(arrays["inv_mass"], arrays["inv_inertia"], velocity, strict=True):
        energy += 0.5 * v[:3] @ v[:3] / m
        if np.any(i):
            energy += 0.5 * v[3:] @ np.linalg.solve(i, v[3:])
    return energy
