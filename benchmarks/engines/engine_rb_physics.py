from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

import numpy as np

import rb_physics as rb

from .scene import Ball, Block, Scene, Shape


def shape_of(shape: Shape):
    if isinstance(shape, Ball):
        return rb.Sphere(shape.radius)
    if isinstance(shape, Block):
        return rb.Box(shape.half)
    return rb.ConvexHull(shape.vertices)


class RbPhysics:
    name = "rb_physics"
    precision = "f64"

    def __init__(self, scene: Scene) -> None:
        self.world = rb.World(dt=scene.dt)
        surface = {"friction": scene.friction, "restitution": scene.restitution}
        self.bodies = []
        for item in scene.items:
            kind = {"type": "kinematic"} if item.kinematic else {"mass": item.mass}
            self.bodies.append(
                self.world.add_body(
                    shape_of(item.shape),
                    position=item.position,
                    orientation=item.orientation,
                    linear_velocity=item.velocity,
                    **kind,
                    **surface,
                )
            )
        for plane in scene.planes:
            self.world.add_body(rb.HalfSpace(plane.normal, plane.offset), type="static", **surface)
        self.step_once = self.world.step

    @staticmethod
    def version() -> str:
        try:
            return version("rb_physics")
        except PackageNotFoundError:
            return "source"

    def step(self, count: int) -> None:
        self.world.step(count)

    def push(self, force: np.ndarray) -> None:
        self.bodies[0].apply_wrench(force, (0, 0, 0), duration=0)

    def poses(self) -> tuple[np.ndarray, np.ndarray]:
        n = len(self.bodies)
        return np.array(self.world.positions[:n]), np.array(self.world.orientations[:n])
