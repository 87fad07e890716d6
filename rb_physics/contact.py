"""What the contact arrays say: kinds, states and the kinematics of a contact (S8, S9, S10)."""

from __future__ import annotations

from enum import IntEnum


class ContactKind(IntEnum):
    """The features that met (S8); the order of A and B does not matter. SMOOTH: a curved surface."""

    VERTEX_FACE = 0
    EDGE_EDGE = 1
    EDGE_FACE = 2
    FACE_FACE = 3
    SMOOTH = 4


class ContactState(IntEnum):
    """The sign of N . V, the relative velocity along the normal (S9)."""

    COLLIDING = 0
    RESTING = 1
    SEPARATING = 2
