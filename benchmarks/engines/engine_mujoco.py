from __future__ import annotations

import mujoco
import numpy as np

from .scene import Ball, Block, Item, Scene, plane_frame, quaternion


def text(numbers) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def wxyz(q) -> str:
    return text((q[3], q[0], q[1], q[2]))


class MuJoCo:
    """Contacts at their defaults, which know no coefficient of restitution. Kinematic bodies are driven
    along a slide joint: a mocap body would move without a velocity."""

    name = "MuJoCo"
    precision = "f64"

    def __init__(self, scene: Scene) -> None:
        meshes: dict[object, str] = {}
        bodies = "".join(self.body(item, meshes) for item in scene.items)
        planes = "".join(
            f'<geom type="plane" size="0 0 1" pos="{text(np.multiply(p.normal, p.offset))}" '
            f'quat="{wxyz(quaternion(plane_frame(p)))}"/>'
            for p in scene.planes
        )
        assets = "".join(
            f'<mesh name="{name}" vertex="{text(np.ravel(shape.vertices))}"/>'
            for shape, name in meshes.items()
        )
        self.model = mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{scene.dt}" gravity="0 0 -9.81"/><size memory="2G"/>'
            f'<default><geom friction="{scene.friction} 0 0" density="1000"/></default>'
            f"<asset>{assets}</asset><worldbody>{planes}{bodies}</worldbody></mujoco>"
        )
        self.data = mujoco.MjData(self.model)
        self.driven = [k for k, item in enumerate(scene.items) if item.kinematic]
        self.speed = np.array([np.linalg.norm(scene.items[k].velocity) for k in self.driven])
        self.dofs = self.model.body_dofadr[[k + 1 for k in self.driven]] if self.driven else None
        for k, item in enumerate(scene.items):
            if not item.kinematic:
                self.data.qvel[self.model.body_dofadr[k + 1] :][:3] = item.velocity
        mujoco.mj_forward(self.model, self.data)

    @staticmethod
    def body(item: Item, meshes: dict) -> str:
        if isinstance(item.shape, Ball):
            geom = f'<geom type="sphere" size="{item.shape.radius}"/>'
        elif isinstance(item.shape, Block):
            geom = f'<geom type="box" size="{text(item.shape.half)}"/>'
        else:
            mesh = meshes.setdefault(item.shape, f"hull{len(meshes)}")
            geom = f'<geom type="mesh" mesh="{mesh}"/>'
        joint, more = "<freejoint/>", ""
        if item.kinematic:
            joint, more = f'<joint type="slide" axis="{text(item.velocity)}"/>', ' gravcomp="1"'
            geom = geom.replace("/>", ' mass="1e6"/>')
        return (
            f'<body pos="{text(item.position)}" quat="{wxyz(item.orientation)}"{more}>'
            f"{joint}{geom}</body>"
        )

    @staticmethod
    def version() -> str:
        return mujoco.__version__

    def step_once(self) -> None:
        mujoco.mj_step(self.model, self.data)

    def step(self, count: int) -> None:
        if self.dofs is None:
            mujoco.mj_step(self.model, self.data, count)
            return
        for _ in range(count):
            self.data.qvel[self.dofs] = self.speed
            mujoco.mj_step(self.model, self.data)

    def push(self, force: np.ndarray) -> None:
        self.data.xfrc_applied[1, :3] = force

    def poses(self) -> tuple[np.ndarray, np.ndarray]:
        # mj_step leaves xpos of the step's start; kinematics only, at the new positions.
        mujoco.mj_kinematics(self.model, self.data)
        return self.data.xpos[1:].copy(), self.data.xquat[1:][:, [1, 2, 3, 0]]
