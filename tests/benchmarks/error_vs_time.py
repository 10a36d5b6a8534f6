# SPDX-License-Identifier: GPL-3.0-or-later
"""rms error of F0 on vertices against the seconds it took, at 16, 64 and 256 samples: the extension, Cycles, and peers.

Seconds are of the whole bake, scene build and all; a peer's are of its script (peers.py), to the array of results. The
truth is jittered random rays (truth.py) at random vertices. Cycles bakes a smooth mesh both ways that it knows: a value
a face corner, and a value a vertex, the mean of its corners' rays.
"""

from __future__ import annotations

import meshes
import numpy as np
from bakes import AO, CYCLES, by_cycles, by_the_extension, colours, domain_of
from peers import PEERS, Peer
from report import Plot, Report, time_to
from timing import side_by_side
from truth import Geometry, rms

TARGET = 0.01
CORNERS = "Cycles, a value a corner"
SAMPLES = (16, 64, 256)
# Random rays need several times more for the same error, and a fast tracer of them is soon done.
CORNER_SAMPLES = (*SAMPLES, 1024)
PEER_SAMPLES = (*SAMPLES, 1024, 2048)
PEER_SECONDS = 12.0  # a run that would take longer is left out


def main(report: Report, quick: bool) -> None:
    for name, make in ({"coral": lambda: meshes.coral(5 if quick else 7)} | meshes.added()).items():
        _mesh(report, name, make(), quick)


def _mesh(report: Report, name: str, obj, quick: bool) -> None:
    geometry = Geometry.of(obj)
    domain = domain_of(obj)
    points, normals = geometry.elements(domain)
    chosen = np.random.default_rng(0).permutation(geometry.used(domain))[: 300 if quick else 2000]
    truth = {"cosine": geometry.visibility(points[chosen], normals[chosen])}
    curves: dict[str, tuple[list[float], list[float]]] = {}

    def measured(who: str, taken: float, error: float, samples: int) -> None:
        for values, value in zip(curves.setdefault(who, ([], [])), (taken, error), strict=True):
            values.append(value)
        report.note(f"{name}, {samples:4} samples: {who:24} {taken:7.3f} s, rms {error:.4f}")

    for samples in SAMPLES[: 2 if quick else None]:

        def ours(samples=samples):
            meshes.nudge(obj)
            return by_the_extension(obj, samples)

        bakes = {"the extension": ours, "Cycles": lambda samples=samples: by_cycles(obj, samples)}
        taken = side_by_side(bakes, 1 if quick else 3, 5.0)
        for who, attribute in (("the extension", AO), ("Cycles", CYCLES)):
            measured(who, taken[who], rms(colours(obj, attribute)[chosen, 0], truth["cosine"]), samples)

    if domain == "POINT":
        corner = np.zeros(len(points), np.intp)  # any one of each vertex
        corner[geometry.corner_vertex] = np.arange(len(geometry.corner_vertex))
        for samples in CORNER_SAMPLES[: 2 if quick else None]:
            taken = by_cycles(obj, samples, domain="CORNER")
            measured(CORNERS, taken, rms(colours(obj, CYCLES)[corner[chosen], 0], truth["cosine"]), samples)

    for peer in PEERS:
        if domain == "CORNER" or not peer.installed:
            continue
        if peer.density not in truth:
            truth[peer.density] = geometry.visibility(points[chosen], normals[chosen], peer.density)
        try:
            _trace(peer, geometry, 1)  # loads and compiles what it needs
        except ImportError as error:
            report.note(f"{peer.name} is installed but cannot be loaded: {error}")
            continue
        taken, error, last = 0.0, 1.0, 1
        for samples in PEER_SAMPLES[: 2 if quick else None]:
            if error < TARGET or taken * samples / last > PEER_SECONDS:
                break
            taken, values = _trace(peer, geometry, samples)
            error, last = rms(values[chosen], truth[peer.density]), samples
            measured(peer.name, taken, error, samples)

    reach = {who: time_to(TARGET, *curve) for who, curve in curves.items()}
    report.note(f"{name}: the extension reaches rms {TARGET} in {reach['the extension']:.2f} s")
    for who, asked in ((CORNERS, "≥ 25"), ("Cycles", "≥ 25"), ("Mitsuba", "≥ 2")):
        if who in reach:
            times = f"{reach[who] / reach['the extension']:.1f}" if np.isfinite(reach[who]) else "never there"
            report.add(f"{name}: times sooner at rms {TARGET} than {who}", times, asked)
    report.plot(
        Plot(
            f"error_{name}",
            f"{name}, {len(points):,} {'vertices' if domain == 'POINT' else 'face corners'}",
            "seconds, whole bake",
            "rms error of ambient occlusion",
            [(who, *curve) for who, curve in curves.items()],
            line=(TARGET, f"rms {TARGET}"),
        )
    )


def _trace(peer: Peer, geometry: Geometry, samples: int) -> tuple[float, np.ndarray]:
    return peer.trace(geometry.vertices, geometry.triangles, geometry.vertices, geometry.vertex_normals, samples)
