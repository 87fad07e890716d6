"""test_intersection of a mesh and a height field never came back; other queries of two surfaces or
half-spaces named no body, and time_of_impact said that a moving mesh meets nothing."""

import itertools

import numpy as np
import pytest

import rb_physics as rb

CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
QUERIES = {
    "test_intersection": rb.test_intersection,
    "find_contacts": rb.find_contacts,
    "distance": rb.distance,
    "time_of_impact": lambda a, b: rb.time_of_impact(a, b, 1.0),
}


@pytest.mark.parametrize("query", QUERIES.values(), ids=QUERIES)
def test_queries_of_two_pieces_of_scenery_are_refused(query):
    world = rb.World()
    for name, shape, kind in (
        ("plane", rb.HalfSpace((0, 0, 1), 0.0), "static"),
        ("low", rb.HalfSpace((0, 0, 1), -1.0), "static"),
        ("mesh", rb.TriangleMesh(CORNERS, FACES), "static"),
        ("field", rb.HeightField(np.zeros((2, 2)), 1), "static"),
        ("cart", rb.TriangleMesh(CORNERS, FACES), "kinematic"),
    ):
        world.add_body(shape, type=kind, name=name)
    for a, b in itertools.permutations(world.bodies, 2):
        with pytest.raises(rb.SceneError, match=f"{a.name!r}.*{b.name!r}.*must have another shape"):
            query(a, b)
