"""Each frame_id means what the table of wrench_frames says."""

import numpy as np
import pytest
from rb_physics_nodes.refused import UnknownFrameError
from rb_physics_nodes.wrench_frames import WrenchFrames

QUARTER_TURN_Z = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))
FRAMES = WrenchFrames("box", (0.1, 0.0, 0.0), {"tip": ((0.5, 0.0, 0.0), QUARTER_TURN_Z)})
FORCE, TORQUE = (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)
ROUNDING = 1e-15  # a few sums and products of numbers of size one to ten


def test_world_acts_at_the_centre_of_mass_in_world_axes():
    assert FRAMES.resolve("world", FORCE, TORQUE) == (False, FORCE, TORQUE)


def test_com_has_body_axes():
    assert FRAMES.resolve("box/com", FORCE, TORQUE) == (True, FORCE, TORQUE)


def test_body_frame_acts_at_its_origin():
    wrench = FRAMES.resolve("box", FORCE, TORQUE)
    assert wrench.in_body_axes
    assert wrench.force == FORCE
    lever = np.array([-0.1, 0.0, 0.0])
    np.testing.assert_allclose(wrench.torque, TORQUE + np.cross(lever, FORCE), rtol=ROUNDING)


def test_further_frame_turns_and_shifts():
    wrench = FRAMES.resolve("box/tip", FORCE, TORQUE)
    force = np.array([-2.0, 1.0, 3.0])  # a quarter turn takes x to y and y to -x
    torque = np.array([-5.0, 4.0, 6.0]) + np.cross([0.4, 0.0, 0.0], force)
    np.testing.assert_allclose(wrench.force, force, atol=10 * ROUNDING)
    np.testing.assert_allclose(wrench.torque, torque, atol=10 * ROUNDING)


@pytest.mark.parametrize("frame", ["", "other", "box/nothing", "/world", "box/", "tip"])
def test_other_frames_are_refused_with_the_list_of_valid_ones(frame):
    with pytest.raises(UnknownFrameError) as refused:
        FRAMES.resolve(frame, FORCE, TORQUE)
    assert str(refused.value).endswith("must be one of box, box/com, box/tip, world")
    assert ("empty frame" if not frame else f"'{frame}'") in str(refused.value)
