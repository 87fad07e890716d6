from __future__ import annotations

import numpy as np
import pybullet as p

from .scene import Ball, Block, Scene, Shape


def collision_shape(shape: Shape) -> int:
    if isinstance(shape, Ball):
        return p.createCollisionShape(p.GEOM_SPHERE, radius=shape.radius)
    if isinstance(shape, Block):
        return p.createCollisionShape(p.GEOM_BOX, halfExtents=shape.half)
    return p.createCollisionShape(p.GEOM_MESH, vertices=[list(v) for v in shape.vertices])


class PyBullet:
    name = "PyBullet"
    precision = "f64"

    def __init__(self, scene: Scene) -> None:
        p.connect(p.DIRECT)
        p.resetSimulation()
        p.setGravity(0, 0, -9.81)
        p.setPhysicsEngineParameter(fixedTimeStep=scene.dt)
        shapes: dict[Shape, int] = {}
        self.bodies: list[int] = []
        self.driven: list[tuple[int, tuple]] = []
        surface = {
            "lateralFriction": scene.friction,
            "restitution": scene.restitution,
            "linearDamping": 0,
            "angularDamping": 0,
            "activationState": p.ACTIVATION_STATE_DISABLE_SLEEPING,
        }
        for item in scene.items:
            if item.shape not in shapes:
                shapes[item.shape] = collision_shape(item.shape)
            body = p.createMultiBody(
                0 if item.kinematic else item.mass,
                shapes[item.shape],
                basePosition=item.position,
                baseOrientation=item.orientation,
            )
            p.changeDynamics(body, -1, **surface)
            p.resetBaseVelocity(body, item.velocity, (0, 0, 0))
            if item.kinematic:
                self.driven.append((body, item.velocity))
            self.bodies.append(body)
        for plane in scene.planes:
            shape = p.createCollisionShape(p.GEOM_PLANE, planeNormal=plane.normal)
            body = p.createMultiBody(
                0, shape, basePosition=list(np.multiply(plane.normal, plane.offset))
            )
            p.changeDynamics(body, -1, **surface)

    @staticmethod
    def version() -> str:
        from importlib.metadata import version

        return version("pybullet")

    def step_once(self) -> None:
        p.stepSimulation()

    def step(self, count: int) -> None:
        for _ in range(count):
            for body, velocity in self.driven:
                p.resetBaseVelocity(body, velocity, (0, 0, 0))
            p.stepSimulation()

    def push(self, force: np.ndarray) -> None:
        x, _ = p.getBasePositionAndOrientation(self.bodies[0])
        p.applyExternalForce(self.bodies[0], -1, force, x, p.WORLD_FRAME)

    def poses(self) -> tuple[np.ndarray, np.ndarray]:
        both = [p.getBasePositionAndOrientation(body) for body in self.bodies]
        return np.array([x for x, _ in both]), np.array([q for _, q in both])
