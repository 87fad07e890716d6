"""A scene with a convex hull ended the recording: the hull was asked for triangles it does not have."""

import numpy as np

import rb_physics as rb
from rb_physics.recording.geometry import shape_parts

CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)


def test_a_hull_has_a_picture_made_of_its_faces():
    (part,) = shape_parts(rb.ConvexHull(0.1 * CUBE))
    vertices = np.array(part.vertices)
    corners = vertices[np.array(part.triangles)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1).sum() / 2
    assert abs(area - 6 * 0.2**2) < 1e-15  # rounding
    assert ((corners.mean(axis=1) * normals).sum(axis=1) > 0).all()  # outward
