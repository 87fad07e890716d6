"""S15: -d/a <= f <= -2 d/a for one contact, which restitution 0 to 1 spans."""

import pytest

from rb_physics._core import solver


@pytest.mark.parametrize("d_dot", [-1e-9, -0.3, -7.0])
@pytest.mark.parametrize("a", [1e-4, 0.7, 3e5])
def test_restitution_spans_the_bounds(d_dot, a):
    low, high = -d_dot / a, -2 * d_dot / a
    # One rounding each.
    assert solver.single_contact_impulse(d_dot, a, 0.0) == pytest.approx(low, rel=4e-16)
    assert solver.single_contact_impulse(d_dot, a, 1.0) == pytest.approx(high, rel=4e-16)
    middle = solver.single_contact_impulse(d_dot, a, 0.4)
    assert low < middle < high


@pytest.mark.parametrize("restitution", [-0.1, 1.1])
def test_impulse_outside_the_bounds_is_refused(restitution):
    with pytest.raises(RuntimeError, match="-d/a <= f <= -2d/a"):
        solver.single_contact_impulse(-1.0, 1.0, restitution)


def test_parting_contact_gets_nothing():
    assert solver.single_contact_impulse(0.0, 1.0, 0.5) == 0.0
