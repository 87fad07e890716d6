"""The notes' wedge: a ball at rest on two walls, hit from above (S12, S13)."""

import numpy as np

N0 = np.array([1, 0, 1]) / np.sqrt(2)
N1 = np.array([-2, 0, 1]) / np.sqrt(5)


def particle_in_wedge(stage, order=(0, 1), restitution=1.0, speed=1.0, walls=(0, 1)):
    """World, ball and wall normals; v = (0, -speed), no gravity, walls added in ``order``."""
    world = stage.world(1e-3, gravity=(0, 0, 0))
    normals = [(N0, N1)[k] for k in order if k in walls]
    for n in normals:
        stage.plane(world, n, friction=0.0, restitution=restitution)
    radius = 0.1
    # The centre is one radius from each wall: two equations in the plane of the wedge.
    A = np.array([[N0[0], N0[2]], [N1[0], N1[2]]])
    x, z = np.linalg.solve(A, (radius, radius))
    ball = stage.add(
        world, stage.sphere(radius), 1.0, (x, 0, z), velocity=(0, 0, -speed), friction=0.0
    )
    return world, ball, normals
