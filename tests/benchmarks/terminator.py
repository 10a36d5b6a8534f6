# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays start on coarse meshes that are shaded smooth: F0 on them against the ideal surface that they show.

Compared are the face itself; the face with the rays below it left out; Hanika's lift; and core/terminator.py's. On an
unoccluded ball every point should see all of the sky.
"""

from __future__ import annotations

import numpy as np
from report import Report

from core.rays import Obscurance, Occluders
from core.sample_points import spread
from core.terminator import Terminator

RAYS, FINE_RAYS = 256, 1024
MAJOR, MINOR = 1.0, 0.5


def main(report: Report, quick: bool) -> None:
    count = 500 if quick else 5000
    for name, mesh in {"12 x 6 ball": _ball(12, 6), "16-sided tube": _tube(16)}.items():
        lowest = {way: _f0(mesh, *start).min() for way, start in _starts(mesh, count).items()}
        report.note(f"{name}, lowest F0: " + ", ".join(f"{way} {value:.4f}" for way, value in lowest.items()))
        report.add(f"{name}: lowest F0", f"{lowest['lifted']:.4f}", "> .995")
    ideal = _torus(512, 256)
    for segments in (16, 24, 48):
        name = f"torus of {segments} x {segments // 2}"
        _compare(report, name, _torus(segments, segments // 2), ideal, _on_torus, count)
    ideal = _waves(400)
    for steps in (20, 40):
        _compare(report, f"waves of {steps} x {steps}", _waves(steps), ideal, _on_waves, count)


def _compare(report: Report, name: str, mesh: tuple, ideal: tuple, on_ideal, count: int) -> None:
    """The rms error of F0 on ``mesh`` against F0 at the same places ``on_ideal``."""
    starts = _starts(mesh, count)
    at, normal = on_ideal(starts["on the face"][0])
    # The ideal's own faces, fine as they are, lie a little above it in hollows.
    truth = _f0(ideal, at + 1e-4 * normal, normal, rays=FINE_RAYS)
    error = {way: np.sqrt(np.mean((_f0(mesh, *start) - truth) ** 2)) for way, start in starts.items()}
    report.note(f"{name}, rms of F0: " + ", ".join(f"{way} {value:.4f}" for way, value in error.items()))
    report.add(f"{name}: rms of F0, lifted", f"{error['lifted']:.4f}")


def _starts(mesh: tuple, count: int) -> dict[str, tuple]:
    """By name, arguments of :func:`_f0`: positions and normals (n, 3), and perhaps the faces' normals."""
    vertices, normals, triangles = mesh
    corners, corner_normals = vertices[triangles], normals[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    triangle, v, w = spread(np.linalg.norm(faces, axis=1), count)
    faces = (faces / np.linalg.norm(faces, axis=1, keepdims=True))[triangle]
    weights = np.stack((1.0 - v - w, v, w), axis=1)
    at = np.einsum("nc,ncx->nx", weights, corners[triangle])
    normal = np.einsum("nc,ncx->nx", weights, corner_normals[triangle])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    below = np.einsum("ncx,ncx->nc", corners[triangle] - at[:, None], corner_normals[triangle])
    hanika = at + np.einsum("nc,nc,ncx->nx", weights, np.maximum(below, 0.0), corner_normals[triangle])
    table = Terminator(np.moveaxis(corners, 0, 2), np.moveaxis(corner_normals, 0, 2))
    lift = np.maximum(np.minimum(*table.heights(triangle, v, w)), 0.0)
    return {
        "on the face": (at, normal),
        "rays below it left out": (at, normal, faces),
        "Hanika": (hanika, normal),
        "lifted": (at + lift[:, None] * normal, normal),
    }


def _f0(mesh, at, normal, faces=None, rays=RAYS) -> np.ndarray:
    """(n,): the share of cosine-weighted rays that escape, of those above ``faces`` where these are given."""
    occluders, random = Occluders(mesh[0], mesh[2]), np.random.default_rng(0)
    turn = random.random(len(at))[:, None] * 2.0 * np.pi + np.arange(rays) * np.pi * (3.0 - 5.0**0.5)
    z = np.sqrt((np.arange(rays) + 0.5) / rays)
    side = np.cross(normal, np.where(np.abs(normal[:, :1]) < 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    x, y = np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn)
    directions = x[..., None] * side[:, None] + y[..., None] * np.cross(normal, side)[:, None]
    directions += z[:, None] * normal[:, None]
    origins = np.broadcast_to(occluders.origins(at.T, normal.T, 2.0).T[:, None], directions.shape)
    flat = [np.ascontiguousarray(each.reshape(-1, 3), np.float32) for each in (origins, directions)]
    visible = occluders.visibility(*flat, Obscurance()).reshape(len(at), rays)
    if faces is None:
        return visible.mean(axis=1)
    counts = np.einsum("nrx,nx->nr", directions, faces) > 0.0
    return (visible * counts).sum(axis=1) / counts.sum(axis=1)


def _ball(segments: int, rings: int) -> tuple:
    polar = np.pi * (np.arange(rings + 1) / rings - 0.5)
    return _turned(np.column_stack((np.cos(polar), np.sin(polar))), None, segments, is_ring=False)


def _tube(segments: int) -> tuple:
    return _turned(np.array([(1.0, -2.0), (1.0, 2.0)]), np.array([(1.0, 0.0)] * 2), segments, is_ring=False)


def _torus(segments: int, sides: int) -> tuple:
    angle = 2.0 * np.pi * np.arange(sides) / sides
    out = np.column_stack((np.cos(angle), np.sin(angle)))
    return _turned((MAJOR, 0.0) + MINOR * out, out, segments, is_ring=True)


def _on_torus(at) -> tuple:
    ring = at * (1.0, 1.0, 0.0)
    ring *= MAJOR / np.linalg.norm(ring, axis=1, keepdims=True)
    normal = (at - ring) / np.linalg.norm(at - ring, axis=1, keepdims=True)
    return ring + MINOR * normal, normal


def _waves(steps: int) -> tuple:
    """A sheet of 2 x 2 with three by two hills and hollows."""
    t = np.linspace(-1.0, 1.0, steps + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(t, t))
    vertices, normals = _on_waves(np.stack((x, y, 0.0 * x), axis=1))
    low = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    up = low + steps + 1
    return vertices, normals, np.concatenate((np.stack((low, low + 1, up + 1), 1), np.stack((low, up + 1, up), 1)))


def _on_waves(at) -> tuple:
    x, y = at[:, 0], at[:, 1]
    z = 0.12 * np.sin(9.0 * x) * np.cos(6.0 * y)
    slope_x, slope_y = 1.08 * np.cos(9.0 * x) * np.cos(6.0 * y), -0.72 * np.sin(9.0 * x) * np.sin(6.0 * y)
    normal = np.stack((-slope_x, -slope_y, np.ones_like(x)), axis=1)
    return np.stack((x, y, z), axis=1), normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _turned(profile, normals, segments: int, is_ring: bool) -> tuple:
    """Vertices, normals and triangles of a profile (p, 2) in r and z, turned about z; its normals default to itself."""
    azimuth = 2.0 * np.pi * np.arange(segments) / segments
    turn = np.stack((np.cos(azimuth), np.sin(azimuth)), axis=1)
    vertices, normals = (
        np.concatenate(
            (turn[:, None] * each[:, :1], np.broadcast_to(each[:, 1:], (segments, len(each), 1))), axis=2
        ).reshape(-1, 3)
        for each in (profile, profile if normals is None else normals)
    )
    index = np.arange(len(vertices)).reshape(segments, -1)
    if is_ring:
        index = np.column_stack((index, index[:, 0]))
    a, b = index, np.roll(index, -1, axis=0)
    quads = np.stack((a[:, :-1], b[:, :-1], b[:, 1:], a[:, 1:]), axis=-1).reshape(-1, 4)
    triangles = np.concatenate((quads[:, (0, 1, 2)], quads[:, (0, 2, 3)]))
    edges = vertices[triangles[:, 1:]] - vertices[triangles[:, :1]]
    return vertices, normals, triangles[np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) > 1e-9]
