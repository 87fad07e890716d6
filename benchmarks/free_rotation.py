"""Attitude of a free rigid body in closed form: Jacobi elliptic functions, precession by quadrature.

Landau & Lifshitz, Mechanics, section 37. Extended precision and differences of squares written
without cancellation: near the unstable axis an error of 1e-16 in the parameter would show.
"""

from __future__ import annotations

import numpy as np

Real = np.longdouble


def _amplitude(u, m1):
    """Jacobi's am(u), parameter m = 1 - m1, by descending Landen transformations (A&S 16.4)."""
    a, b, c = [Real(1)], [np.sqrt(Real(m1))], [np.sqrt(1 - Real(m1))]
    while abs(c[-1]) > 1e-19 and len(a) < 20:
        a.append((a[-1] + b[-1]) / 2)
        c.append((a[-2] - b[-1]) / 2)
        b.append(np.sqrt(a[-2] * b[-1]))
    phi = 2 ** (len(a) - 1) * a[-1] * u
    for n in range(len(a) - 1, 0, -1):
        phi = (phi + np.arcsin(c[n] / a[n] * np.sin(phi))) / 2
    return phi


def _inverse_amplitude(phi, m1):
    """u with am(u) = phi: bisection, am grows with u."""
    low, high = Real(-200), Real(200)
    for _ in range(120):
        u = (low + high) / 2
        if _amplitude(u, m1) < phi:
            low = u
        else:
            high = u
    return (low + high) / 2


def body_rates(moments, spin, t):
    """omega (n, 3) in body axes at the times t; moments ascending, L² > 2 E I_2, omega_3 > 0."""
    I1, I2, I3 = (Real(v) for v in moments)
    w1, w2, w3 = (Real(v) for v in spin)
    # L² - 2 E I_j, without cancellation.
    over1 = I2 * (I2 - I1) * w2**2 + I3 * (I3 - I1) * w3**2
    over2 = I1 * (I1 - I2) * w1**2 + I3 * (I3 - I2) * w3**2
    under3 = I1 * (I3 - I1) * w1**2 + I2 * (I3 - I2) * w2**2
    if not (over2 > 0 and w3 > 0):
        raise ValueError("written for rotation about the axis of the largest moment")
    m1 = (I3 - I1) * over2 / ((I3 - I2) * over1)
    rate = np.sqrt((I3 - I2) * over1 / (I1 * I2 * I3))
    peak1 = np.sqrt(under3 / (I1 * (I3 - I1)))
    peak2 = np.sqrt(under3 / (I2 * (I3 - I2)))
    peak3 = np.sqrt(over1 / (I3 * (I3 - I1)))
    # omega = (peak1 cn, peak2 sn, peak3 dn) solves Euler's equations with sn' = cn dn > 0.
    start = _inverse_amplitude(np.arctan2(w2 / peak2, w1 / peak1), m1)
    phi = _amplitude(rate * np.asarray(t, Real) + start, m1)
    sn, cn = np.sin(phi), np.cos(phi)
    return np.stack([peak1 * cn, peak2 * sn, peak3 * np.sqrt(cn**2 + m1 * sn**2)], axis=-1)


def _body_to_momentum(L):
    """Rows: axes of the frame (body's third axis across L, the other across, L), body coordinates."""
    z = L / np.sqrt((L**2).sum())
    x = np.array([0, 0, 1], Real) - z[2] * z
    x = x / np.sqrt((x**2).sum())
    return np.stack([x, np.cross(z, x), z])


def attitude_of_free_rotation(moments, spin, t: float) -> np.ndarray:
    """Unit quaternion x y z w at time t; the body starts unturned with body rates ``spin``."""
    inertia = np.asarray(moments, Real)
    panels = max(64, int(60 * t))
    nodes, weights = np.polynomial.legendre.leggauss(16)
    edges = np.linspace(0, t, panels + 1)
    half = np.diff(edges)[:, None] / 2
    times = (edges[:-1, None] + half + half * nodes).ravel()
    w = body_rates(moments, spin, times)
    L = inertia * w
    across = L[:, 0] ** 2 + L[:, 1] ** 2
    norm = np.sqrt((L[0] ** 2).sum())
    precession = norm * (L[:, 0] * w[:, 0] + L[:, 1] * w[:, 1]) / across
    angle = (precession.reshape(panels, -1) * weights * half).sum()
    first = _body_to_momentum(inertia * np.asarray(spin, Real))
    last = _body_to_momentum(inertia * body_rates(moments, spin, t))
    c, s = np.cos(angle), np.sin(angle)
    about_L = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return _quaternion((first.T @ about_L @ last).astype(float))


def _quaternion(R: np.ndarray) -> np.ndarray:
    """Of a rotation matrix: the eigenvector form, good for any angle."""
    K = np.array(
        [
            [R[0, 0] - R[1, 1] - R[2, 2], R[1, 0] + R[0, 1], R[2, 0] + R[0, 2], R[2, 1] - R[1, 2]],
            [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], R[2, 1] + R[1, 2], R[0, 2] - R[2, 0]],
            [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
            [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]],
        ]
    )
    return np.linalg.eigh(K)[1][:, -1]
