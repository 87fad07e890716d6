from __future__ import annotations

import dartpy
import numpy as np

from .penetration import rotations
from .scene import Ball, Block, Item, Scene, Shape, quaternion

dart = dartpy.dynamics


def shape_of(shape: Shape):
    if isinstance(shape, Ball):
        return dart.SphereShape(shape.radius)
    if isinstance(shape, Block):
        return dart.BoxShape(2 * np.array(shape.half))
    # The Python face has no convex mesh of vertices; small balls' hull would round the edges.
    raise NotImplementedError("no convex hulls from vertices in dartpy")


class Dart:
    name = "DART"
    precision = "f64"

    def __init__(self, scene: Scene) -> None:
        self.world = dartpy.simulation.World()
        self.world.setGravity([0, 0, -9.81])
        self.world.setTimeStep(scene.dt)
        awake = dartpy.simulation.DeactivationOptions()
        awake.mEnabled = False
        self.world.setDeactivationOptions(awake)
        self.driven: list[tuple] = []
        shapes: dict[Shape, object] = {}
        self.bodies = []
        for k, item in enumerate(scene.items):
            if item.shape not in shapes:
                shapes[item.shape] = shape_of(item.shape)
            self.bodies.append(self.add(f"body{k}", item, shapes[item.shape], scene))
        for k, plane in enumerate(scene.planes):
            skeleton = dart.Skeleton(f"plane{k}")
            _, body = skeleton.createWeldJointAndBodyNodePair()
            node = body.createShapeNode(dart.PlaneShape(np.array(plane.normal), plane.offset))
            self.surface(node, scene)
            self.world.addSkeleton(skeleton)

    def add(self, name: str, item: Item, shape, scene: Scene):
        skeleton = dart.Skeleton(name)
        joint, body = skeleton.createFreeJointAndBodyNodePair()
        self.surface(body.createShapeNode(shape), scene)
        inertia = np.diag(item.mass * np.asarray(item.shape.principal_inertia))
        body.setInertia(dart.Inertia(item.mass, np.zeros(3), inertia))
        turn = rotations(np.array([item.orientation]))[0]
        frame = dartpy.math.Isometry3()
        frame.set_rotation(turn)
        frame.set_translation(np.array(item.position))
        joint.setPositions(dart.FreeJoint.convertToPositions(frame))
        twist = np.concatenate([np.zeros(3), turn.T @ np.array(item.velocity)])
        joint.setVelocities(twist)
        if item.kinematic:
            joint.setActuatorType(dart.VELOCITY)
            self.driven.append((joint, twist))
        self.world.addSkeleton(skeleton)
        return body

    @staticmethod
    def surface(node, scene: Scene) -> None:
        node.createCollisionAspect()
        aspect = node.createDynamicsAspect()
        aspect.setFrictionCoeff(scene.friction)
        aspect.setRestitutionCoeff(scene.restitution)

    @staticmethod
    def version() -> str:
        from importlib.metadata import version

        return version("dartpy")

    def step_once(self) -> None:
        self.world.step()

    def step(self, count: int) -> None:
        for _ in range(count):
            for joint, twist in self.driven:
                joint.setCommands(twist)
            self.world.step()

    def push(self, force: np.ndarray) -> None:
        self.bodies[0].addExtForce(force, np.zeros(3), False, True)

    def poses(self) -> tuple[np.ndarray, np.ndarray]:
        frames = [body.getWorldTransform() for body in self.bodies]
        return (
            np.array([np.ravel(f.translation()) for f in frames]),
            np.array([quaternion(np.asarray(f.rotation())) for f in frames]),
        )
