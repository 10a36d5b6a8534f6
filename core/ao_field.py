# SPDX-License-Identifier: GPL-3.0-or-later
"""An ambient occlusion field: what one object blocks of the sky at any place around it, without a ray.

Around the object's centre, by direction omega and distance r (the notes "Ambient Occlusion Fields", after Kontkanen and
Laine 2005), it gives the solid angle and the mean direction of what is blocked:

    Omega(omega, r)   = 1 / (a r^2 + b r + c + d r sqrt(r^2 - r0^2))
    Upsilon(omega, r) = normalize((r0 / r)^e C0 - r0 omega)

With d = 0 and e = 1 these are the notes' functions. The square root lets a sphere be met, and e how fast the direction
turns from what a face beside the receiver has to the centre's.

A cap is a poor likeness of an open shape, a ring or a table, so a second radial function Omega_M of the same form, with
the same d, keeps the size of the blocked moment too: M = (1/pi) * integral of w over what is blocked, Omega_M the cap
that has it. Both together make a larger cap that is blocked in part (:func:`core.cap.covered_cap`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .cap import covered_cap, moment_of_cap, occlusion
from .cubemap import lookup


@dataclass(frozen=True)
class FieldVolume:
    """What is blocked at the nodes of a grid over the convex hull's box, in place of the constant A0.

    values  (m, m, m, 4) float64, by x, y, z: the moment M and Omega. All hold in half precision
    low     (3,) float64, object-space metres from the field's centre: where the first node lies
    high    (3,) float64, the last
    p       how fast the shadow turns from the hull's to the grid's
    """

    values: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    p: float

    def at(self, x: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """M (k, 3) and Omega (k,) at ``x`` (k, 3), metres from the field's centre; trilinear, clamped to the box."""
        m = len(self.values)
        place = np.clip((x - self.low) / (self.high - self.low), 0.0, 1.0) * (m - 1)
        first = np.minimum(place.astype(np.intp), m - 2)
        part = place - first
        found = np.zeros((len(x), 4))
        for corner in np.ndindex(2, 2, 2):
            weight = np.where(corner, part, 1.0 - part).prod(axis=1)
            found += weight[:, None] * self.values[tuple((first + corner).T)]
        return found[:, :3], found[:, 3]


@dataclass(frozen=True)
class Caps:
    """What k receivers see of one object: caps, blocked in part.

    direction    (k, 3) float64, Upsilon, unit length
    solid_angle  (k,) float64, of the cap, in (0, 4pi]
    part         (k,) float64 in (0, 1], t: how much of the cap is blocked
    """

    direction: NDArray[np.float64]
    solid_angle: NDArray[np.float64]
    part: NDArray[np.float64]

    def occlusion(self, normals: NDArray) -> NDArray[np.float64]:
        """A (k,) for unit ``normals`` (k, 3)."""
        return self.part * occlusion(self.solid_angle, np.einsum("kx,kx->k", normals, self.direction))


@dataclass(frozen=True)
class AOField:
    """The field of one object. Lengths are object-space metres, maps are as :mod:`core.cubemap` lays them out.

    centre         (3,) float64, in the object's space
    radius         of the sphere about the centre that holds the object
    r_near, r_far  distances from the centre between which the shadow fades out
    a, b, c, d     (6, n, n) float64, of the denominator of Omega: 1/(sr m^2), 1/(sr m), 1/sr, 1/(sr m^2)
    r0             (6, n, n) float64, distance from the centre to the convex hull
    a_m, b_m, c_m  (6, n, n) float64, as a, b, c of Omega_M
    c0             (6, n, n, 3) float64, C0, metres from the centre
    e              (6, n, n) float64, at least 1: how soon the direction is that of the centre
    a0, p          A0, the occlusion at the centre, and how fast it turns from the hull's to that
    volume         what is blocked inside the hull, in place of A0, or None

    All maps hold in float32, so that files keep them exactly.
    """

    centre: NDArray[np.float64]
    radius: float
    r_near: float
    r_far: float
    a: NDArray[np.float64]
    b: NDArray[np.float64]
    c: NDArray[np.float64]
    d: NDArray[np.float64]
    r0: NDArray[np.float64]
    a_m: NDArray[np.float64]
    b_m: NDArray[np.float64]
    c_m: NDArray[np.float64]
    c0: NDArray[np.float64]
    e: NDArray[np.float64]
    a0: float
    p: float
    volume: FieldVolume | None = None

    @property
    def resolution(self) -> int:
        """n, texels along a face's side."""
        return self.a.shape[1]

    def occlusion(self, positions: ArrayLike, normals: ArrayLike, *, plain_cap: bool = False) -> NDArray[np.float64]:
        """A (k,) in [0, 1], what the object blocks of the cosine-weighted sky, at ``positions`` (k, 3) for unit
        ``normals`` (k, 3), both in the object's space.

        plain_cap  as in the notes: a cap of Omega, without its second moment (nor the volume)

        Step by step the notes' pseudo-code (4. Implementation, "Run-Time"), whose smoothstep has its edges reversed.
        """
        normals = np.asarray(normals, np.float64)
        A = self.caps(positions, plain_cap=plain_cap).occlusion(normals)
        ratio = self.ratio(positions)
        if self.volume is None or plain_cap:
            t = ratio**self.p
            A = t * A + (1.0 - t) * self.a0
        else:
            t = ratio**self.volume.p
            inside = np.flatnonzero(t < 1.0)
            A0 = self.volume_caps(np.asarray(positions)[inside]).occlusion(normals[inside])
            A[inside] = t[inside] * A[inside] + (1.0 - t[inside]) * A0
        return A * self.fade(positions)

    def caps(self, positions: ArrayLike, *, plain_cap: bool = False) -> Caps:
        """What ``positions`` (k, 3) see of the object; inside its hull, what the place above on the hull sees."""
        r, omega = self._polar(positions)
        # A row each: numpy's powers of columns round otherwise where the result happens to lie right behind them.
        of_shape = lookup(np.stack((self.a, self.b, self.c, self.d, self.r0, self.e), axis=-1), omega)
        a, b, c, d, r0, e = np.ascontiguousarray(of_shape.T)
        r_clamp = np.maximum(r, r0)
        root = d * r_clamp * np.sqrt(r_clamp * r_clamp - r0 * r0)
        Omega = 1.0 / ((a * r_clamp + b) * r_clamp + c + root)
        Upsilon = ((r0 / r_clamp) ** e)[:, None] * lookup(self.c0, omega) - r0[:, None] * omega
        Upsilon /= np.linalg.norm(Upsilon, axis=1, keepdims=True)
        if plain_cap:
            return Caps(Upsilon, Omega, np.ones_like(Omega))
        a, b, c = lookup(np.stack((self.a_m, self.b_m, self.c_m), axis=-1), omega).T
        Omega_M = 1.0 / ((a * r_clamp + b) * r_clamp + c + root)
        part, larger = covered_cap(Omega, moment_of_cap(Omega_M))
        return Caps(Upsilon, larger, part)

    def volume_caps(self, positions: ArrayLike) -> Caps:
        """What ``positions`` (k, 3) in the hull see of the object, by its volume."""
        M, Omega = self.volume.at(np.asarray(positions, np.float64) - self.centre)
        length = np.linalg.norm(M, axis=1)
        Omega = np.maximum(Omega, np.finfo(np.float32).tiny)
        part, larger = covered_cap(Omega, length)
        return Caps(M / np.maximum(length, np.finfo(np.float32).tiny)[:, None], larger, part)

    def ratio(self, positions: ArrayLike) -> NDArray[np.float64]:
        """r / r0 (k,) of ``positions`` (k, 3): below 1 in the convex hull, 1 outside."""
        r, omega = self._polar(positions)
        return np.minimum(r / lookup(self.r0, omega), 1.0)

    def fade(self, positions: ArrayLike) -> NDArray[np.float64]:
        """1 (k,) up to ``r_near`` from the centre, 0 from ``r_far``, between them a smoothstep, at ``positions``."""
        r, _ = self._polar(positions)
        s = np.clip((r - self.r_near) / (self.r_far - self.r_near), 0.0, 1.0)
        return 1.0 - s * s * (3.0 - 2.0 * s)

    def _polar(self, positions: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """r (k,) and omega (k, 3) of ``positions`` (k, 3); at the centre any omega does."""
        x = np.asarray(positions, np.float64) - self.centre
        r = np.linalg.norm(x, axis=1)
        return r, np.where(r[:, None] > 0.0, x / np.maximum(r, np.finfo(np.float64).tiny)[:, None], (1.0, 0.0, 0.0))
