# SPDX-License-Identifier: GPL-3.0-or-later
"""Which curve of ambient occlusion comes nearest to the light of all bounces, on surfaces that it was not fitted to.

rms error of E/E0 over the points of each surface against 40 simulated bounces. *k_A*: no bounces. *Published*: the
notes' fit of alpha; *refitted*: the same forms fitted to the other surfaces. *Cubic*: Jimenez et al. 2016. *Any of k_A*
and *any of alpha*: the mean E in bins over all the other surfaces, which no function of it does better on. *Equal*:
k_A / (1 - rho (1 - k_A)), every occluder as bright as the point itself. *Ours*: `surface_curve`, from k_A and one
number for the whole surface, its openness, which is a mean over the same map. *Ours, fitted*: the same with the best
power of the openness on the other surfaces in place of its square root.

That no function of k_A alone does better than *equal* has a reason. Light takes every way in both directions, so over
any closed surface the mean of F1 is the mean of k_A (1 - k_A): *equal* has its first bounce right in the mean
everywhere, and a function that is right in every spherical pit can be no other.
"""

import numpy as np
import surfaces
from report import Report
from scipy.optimize import minimize_scalar

from core import multibounce
from core.bounce_curves import bin_bounces, fit_curves
from core.height_map import HeightMap
from core.rays import Occluders
from core.sample_points import CornerTable
from core.simulation import Simulation, simulate_height_map, simulate_mesh

ALBEDOS = (0.5, 0.8)
BINS = 100


def simulated(surface, quick: bool) -> Simulation:
    samples, bounces = (16, 10) if quick else (256, 40)
    if isinstance(surface, HeightMap):
        work = simulate_height_map(surface, samples=samples, bounces=bounces)
    else:
        occluders, points = Occluders(surface.vertices, surface.vertex_triangles), 500 if quick else 16000
        work = simulate_mesh(
            occluders, CornerTable(surface), points=points, samples=samples, bounces=bounces, extent=surface.extent
        )
    while True:
        try:
            next(work)
        except StopIteration as finished:
            return finished.value


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def weighed_alike(simulations: list[Simulation]) -> Simulation:
    """All in one, with the same number of points of each."""
    count = max(each.alpha.size for each in simulations)
    chosen = [(each, np.arange(count) * each.alpha.size // count) for each in simulations]
    return Simulation(
        np.concatenate([each.alpha[index] for each, index in chosen]),
        np.concatenate([each.bounces[:, index] for each, index in chosen], axis=1),
    )


def bin_means(x, y, at):
    """Mean of ``y`` in bins of ``x`` in [0, 1], looked up ``at`` other values; between bins that hold points, lines."""
    index = np.minimum((x * BINS).astype(int), BINS - 1)
    count = np.bincount(index, minlength=BINS)
    mean = np.bincount(index, weights=y, minlength=BINS)[count > 0] / count[count > 0]
    return np.interp(at, (np.flatnonzero(count) + 0.5) / BINS, mean)


def powers(k, albedo, exponent):
    """`surface_curve` with k' = k^(1 - exponent) openness^exponent."""
    inner = k ** (1.0 - exponent) * multibounce.surface_openness(k) ** exponent
    return k + albedo * (1.0 - k) * multibounce.equal_neighbours(inner, albedo)


def best_exponent(simulations: list[Simulation]) -> float:
    """The exponent of :func:`powers` with the least squares, all surfaces alike."""
    truth = [(each.bounces[0], albedo, each.irradiance(albedo)) for each in simulations for albedo in ALBEDOS]
    return minimize_scalar(
        lambda exponent: sum(rms(powers(k, albedo, exponent) - e) ** 2 for k, albedo, e in truth),
        bounds=(0.0, 1.0),
        method="bounded",
    ).x


def predictions(simulation: Simulation, others: Simulation, exponent: float, albedo: float) -> dict:
    """E/E0 (n,) of each curve at the points of ``simulation``; ``exponent`` is that of :func:`powers`."""
    k, alpha = simulation.bounces[0], simulation.alpha
    light = others.irradiance(albedo)
    return {
        "k_A": k,
        "published": multibounce.irradiance(alpha, albedo),
        "refitted": multibounce.irradiance(alpha, albedo, fit_curves(bin_bounces(others, BINS))),
        "cubic": multibounce.jimenez_2016(k, albedo),
        "any of alpha": bin_means(others.alpha, light, alpha),
        "any of k_A": bin_means(others.bounces[0], light, k),
        "ours, fitted": powers(k, albedo, exponent),
        "equal": multibounce.equal_neighbours(k, albedo),
        "ours": multibounce.surface_curve(k, multibounce.surface_openness(k), albedo),
    }


def main(report: Report, quick: bool) -> None:
    made = {each.__name__: simulated(each(24 if quick else 128), quick) for each in surfaces.HEIGHT_MAPS}
    made |= {each.__name__: simulated(each(), quick) for each in surfaces.MESHES}
    others = {name: [each for other, each in made.items() if other != name] for name in made}
    exponents = {name: best_exponent(rest) for name, rest in others.items()}
    for albedo in ALBEDOS:
        errors = []
        for name, simulation in made.items():
            truth = simulation.irradiance(albedo)
            curves = predictions(simulation, weighed_alike(others[name]), exponents[name], albedo)
            columns = "" if errors else f": {' / '.join(curves)}"
            errors.append([rms(curve - truth) for curve in curves.values()])
            report.add(f"albedo {albedo}, {name.replace('_', ' ')}{columns}", _row(errors[-1]))
        report.add(f"albedo {albedo}, all surfaces alike", _row([rms(column) for column in np.transpose(errors)]))
        worse = sum(row[-1] > row[-2] for row in errors)
        report.add(f"albedo {albedo}: surfaces of {len(errors)} where ours is further off than equal", str(worse))
    low, high = min(exponents.values()), max(exponents.values())
    report.add("the openness's power as fitted, without one surface in turn", f"{low:.2f} .. {high:.2f}")


def _row(errors: list[float]) -> str:
    return " / ".join(f"{error:.3f}".lstrip("0") for error in errors)
