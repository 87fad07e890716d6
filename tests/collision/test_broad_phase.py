"""The pairs of the broad phase are those of the O(n^2) test on the predicted boxes, in sorted
order, whatever happened before."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rb_physics import _core

INF = float("inf")


class BruteForce:
    """The definition: all pairs, one by one."""

    def __init__(self):
        self.bodies = []  # dicts: lower, upper (predicted) or normal, offset; layer, mask, passive

    def pairs(self):
        out = []
        for i, a in enumerate(self.bodies):
            for j in range(i + 1, len(self.bodies)):
                b = self.bodies[j]
                if a["passive"] and b["passive"]:
                    continue
                if not (a["layer"] & b["mask"] and b["layer"] & a["mask"]):
                    continue
                if self.overlap(a, b):
                    out.append((i, j))
        return out

    @staticmethod
    def overlap(a, b):
        if "normal" in a:
            a, b = b, a
        if "normal" in b:
            corner = np.where(b["normal"] > 0, a["lower"], a["upper"])
            return float(corner @ b["normal"]) <= b["offset"]
        return bool(np.all(a["lower"] <= b["upper"]) and np.all(b["lower"] <= a["upper"]))


# A coarse grid makes boxes that touch exactly common.
grid = st.integers(-8, 8).map(lambda n: n / 4)
point = st.tuples(grid, grid, grid).map(np.array)
extent = st.tuples(*[st.integers(0, 6).map(lambda n: n / 4)] * 3).map(np.array)
bits = st.integers(1, 3)
actions = st.lists(
    st.one_of(
        st.tuples(st.just("insert"), point, extent, bits, bits, st.booleans()),
        st.tuples(st.just("plane"), st.sampled_from(range(6)), grid, bits, bits),
        st.tuples(st.just("move"), st.integers(0, 99), point, extent, point),
        st.tuples(st.just("remove"), st.integers(0, 99)),
        st.tuples(st.just("update")),
    ),
    min_size=1,
    max_size=40,
)


def apply(action, broad, brute):
    name, *args = action
    n = len(brute.bodies)
    if name == "insert":
        lower, size, layer, mask, passive = args
        broad.insert(lower, lower + size, layer, mask, passive)
        brute.bodies.append(
            dict(lower=lower, upper=lower + size, layer=layer, mask=mask, passive=passive)
        )
    elif name == "plane":
        side, offset, layer, mask = args
        normal = np.zeros(3)
        normal[side // 2] = 1 - 2 * (side % 2)
        broad.insert_half_space(normal, offset, layer, mask)
        brute.bodies.append(
            dict(normal=normal, offset=offset, layer=layer, mask=mask, passive=True)
        )
    elif name == "move" and n and "normal" not in brute.bodies[args[0] % n]:
        index, lower, size, displacement = args
        broad.move(index % n, lower, lower + size, displacement)
        brute.bodies[index % n] |= dict(
            lower=lower + np.minimum(displacement, 0),
            upper=lower + size + np.maximum(displacement, 0),
        )
    elif name == "remove" and n:
        broad.remove(args[0] % n)
        del brute.bodies[args[0] % n]


@settings(max_examples=300, deadline=None, derandomize=True)
@given(actions, st.sampled_from([0.0, 0.1, 1.0]))
def test_pairs_are_those_of_the_definition(history, fat_margin):
    broad, brute = _core.BroadPhase(fat_margin), BruteForce()
    for action in history:
        apply(action, broad, brute)
        if action[0] == "update":
            assert list(map(tuple, broad.update_pairs())) == brute.pairs()
    assert list(map(tuple, broad.update_pairs())) == brute.pairs()
    assert len(broad) == len(brute.bodies)


def walk(rng, n, steps, speed):
    """Boxes on random straight lines."""
    lower = rng.uniform(0, 10, (n, 3))
    size = rng.uniform(0.05, 0.6, (n, 3))
    velocity = rng.normal(0, speed, (n, 3))
    for _ in range(steps):
        yield lower, lower + size, velocity
        lower = lower + velocity


def brute_pairs(lower, upper, displacement):
    low = lower + np.minimum(displacement, 0)
    high = upper + np.maximum(displacement, 0)
    meet = np.all((low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=2)
    return np.argwhere(np.triu(meet, 1))


@pytest.mark.parametrize("speed", [0.0, 0.003, 0.1, 3.0])
def test_moving_boxes(speed):
    rng = np.random.default_rng(1)
    broad = _core.BroadPhase()
    for step, (lower, upper, d) in enumerate(walk(rng, 300, 40, speed)):
        if step == 0:
            for low, high in zip(lower, upper, strict=True):
                broad.insert(low, high)
        broad.move_all(lower, upper, d)
        np.testing.assert_array_equal(broad.update_pairs(), brute_pairs(lower, upper, d))


def test_pairs_do_not_remember_the_history():
    rng = np.random.default_rng(2)
    old = _core.BroadPhase()
    frames = list(walk(rng, 200, 60, 0.05))
    for low, high in zip(*frames[0][:2], strict=True):
        old.insert(low, high)
    for lower, upper, d in frames:
        old.move_all(lower, upper, d)
        old.update_pairs()
    new = _core.BroadPhase()
    for low, high in zip(*frames[-1][:2], strict=True):
        new.insert(low, high)
    new.move_all(*frames[-1])
    np.testing.assert_array_equal(old.update_pairs(), new.update_pairs())


def test_nothing_leaves_its_fat_box_no_new_candidates():
    rng = np.random.default_rng(3)
    lower = rng.uniform(0, 10, (500, 3))
    broad = _core.BroadPhase()
    for low in lower:
        broad.insert(low, low + 0.5)
    broad.update_pairs()
    before = broad.candidates
    for _ in range(20):
        jitter = rng.uniform(-0.01, 0.01, (500, 3))  # the fat box has 0.05 m of room
        broad.move_all(lower + jitter, lower + jitter + 0.5)
        np.testing.assert_array_equal(
            broad.update_pairs(), brute_pairs(lower + jitter, lower + jitter + 0.5, 0 * jitter)
        )
        assert broad.candidates == before


def test_unbounded_boxes_pair_with_what_they_reach():
    broad = _core.BroadPhase()
    broad.insert([-INF, -INF, -INF], [INF, INF, 0], passive=True)
    broad.insert([0, 0, -0.1], [1, 1, 1])
    broad.insert([0, 0, 0.5], [1, 1, 1])
    assert broad.update_pairs().tolist() == [[0, 1], [1, 2]]
    broad.move(2, [0, 0, 3], [1, 1, 4], [0, 0, -4])
    assert broad.update_pairs().tolist() == [[0, 1], [0, 2], [1, 2]]


def test_tilted_half_space_pairs_only_with_boxes_it_reaches():
    broad = _core.BroadPhase()
    normal = np.array([1.0, 0, 1.0]) / np.sqrt(2)
    broad.insert_half_space(normal, 0.0)
    broad.insert([0.1, 0, 0.1], [1, 1, 1])
    broad.insert([-0.5, 0, 0.4], [1, 1, 1])
    assert broad.update_pairs().tolist() == [[0, 2], [1, 2]]


def test_query_and_ray():
    rng = np.random.default_rng(4)
    lower = rng.uniform(0, 10, (200, 3))
    upper = lower + rng.uniform(0.1, 1, (200, 3))
    broad = _core.BroadPhase()
    for i, (low, high) in enumerate(zip(lower, upper, strict=True)):
        broad.insert(low, high, passive=bool(i % 2))
    for _ in range(50):
        low = rng.uniform(0, 9, 3)
        high = low + rng.uniform(0, 2, 3)
        expected = np.flatnonzero(np.all((lower <= high) & (low <= upper), axis=1))
        assert broad.query(low, high) == expected.tolist()

        origin, direction = rng.uniform(-2, 12, 3), rng.normal(size=3)
        with np.errstate(divide="ignore"):
            t0, t1 = (lower - origin) / direction, (upper - origin) / direction
        enter, leave = np.minimum(t0, t1).max(axis=1), np.maximum(t0, t1).min(axis=1)
        hit = np.flatnonzero((enter <= leave) & (leave >= 0) & (enter <= 5.0))
        assert broad.ray(origin, direction, 5.0) == hit.tolist()


def test_sorted_insertion_keeps_the_tree_shallow():
    broad = _core.BroadPhase()
    for i in range(4096):  # the worst order for a tree that never rotates: depth n
        broad.insert([i, 0, 0], [i + 0.5, 1, 1])
    assert broad.height <= 40  # log2(4096) = 12


@pytest.mark.parametrize(
    ("lower", "upper"),
    [([0, 0, 0], [1, -1, 1]), ([0, 0, float("nan")], [1, 1, 1]), ([0, 0, 0], [1, 1, float("nan")])],
)
def test_bad_boxes_are_refused(lower, upper):
    broad = _core.BroadPhase()
    with pytest.raises(ValueError, match="lower <= upper"):
        broad.insert(lower, upper)
    broad.insert([0, 0, 0], [1, 1, 1])
    with pytest.raises(ValueError, match="lower <= upper"):
        broad.move(0, lower, upper)
    with pytest.raises(IndexError):
        broad.move(1, [0, 0, 0], [1, 1, 1])
    with pytest.raises(ValueError, match="unit normal"):
        broad.insert_half_space([0, 0, 2], 0.0)
