from __future__ import annotations

import numpy as np
import sapien
from sapien import physx

from .scene import Ball, Block, Item, Scene, Shape, plane_frame, quaternion


def pose(position, q) -> sapien.Pose:
    return sapien.Pose(list(position), [q[3], q[0], q[1], q[2]])


class PhysX:
    """Through sapien, with its settings; sleep threshold 0."""

    name = "PhysX"
    precision = "f32"

    def __init__(self, scene: Scene) -> None:
        physx.set_scene_config(gravity=np.array([0, 0, -9.81]))
        physx.set_body_config(sleep_threshold=0.0)
        self.system = physx.PhysxCpuSystem()
        self.scene = sapien.Scene([self.system])
        self.system.timestep = scene.dt
        self.material = physx.PhysxMaterial(scene.friction, scene.friction, scene.restitution)
        self.entities = [self.add(item) for item in scene.items]
        self.components = [
            e.find_component_by_type(physx.PhysxRigidDynamicComponent) for e in self.entities
        ]
        self.driven = [
            (c, np.array(item.velocity), np.array(item.position), item.orientation)
            for c, item in zip(self.components, scene.items, strict=True)
            if item.kinematic
        ]
        self.time, self.dt = 0.0, scene.dt
        for plane in scene.planes:
            shape = physx.PhysxCollisionShapePlane(self.material)
            turn = plane_frame(plane)[:, [2, 0, 1]]  # its normal is the x axis
            shape.local_pose = pose(np.multiply(plane.normal, plane.offset), quaternion(turn))
            body = physx.PhysxRigidStaticComponent()
            body.attach(shape)
            self.enter(body)

    def shape_of(self, shape: Shape) -> physx.PhysxCollisionShape:
        if isinstance(shape, Ball):
            return physx.PhysxCollisionShapeSphere(shape.radius, self.material)
        if isinstance(shape, Block):
            return physx.PhysxCollisionShapeBox(np.array(shape.half), self.material)
        return physx.PhysxCollisionShapeConvexMesh(
            np.array(shape.vertices, np.float32), np.ones(3, np.float32), self.material
        )

    def enter(self, component) -> sapien.Entity:
        entity = sapien.Entity()
        entity.add_component(component)
        self.scene.add_entity(entity)
        return entity

    def add(self, item: Item) -> sapien.Entity:
        body = physx.PhysxRigidDynamicComponent()
        shape = self.shape_of(item.shape)
        shape.density = 1000.0
        body.attach(shape)
        body.kinematic = item.kinematic
        body.linear_damping = body.angular_damping = 0.0
        entity = self.enter(body)
        entity.pose = pose(item.position, item.orientation)
        if not item.kinematic:
            body.linear_velocity = np.array(item.velocity)
        return entity

    @staticmethod
    def version() -> str:
        return f"sapien {sapien.__version__}"

    def step_once(self) -> None:
        self.system.step()

    def step(self, count: int) -> None:
        for _ in range(count):
            self.time += self.dt
            for body, velocity, start, q in self.driven:
                body.kinematic_target = pose(start + self.time * velocity, q)
            self.system.step()

    def push(self, force: np.ndarray) -> None:
        self.components[0].add_force_torque(force, np.zeros(3))

    def poses(self) -> tuple[np.ndarray, np.ndarray]:
        poses = [e.pose for e in self.entities]
        return (
            np.array([p.p for p in poses], float),
            np.array([p.q for p in poses], float)[:, [1, 2, 3, 0]],
        )
