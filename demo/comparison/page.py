# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/bounces.md: the comparisons' pictures and figures, and in short the benchmark of curves."""

import importlib
import shutil
import sys
from pathlib import Path

from .measure import BOUNCES, MODEL_SAMPLES, TEXTURE_SIZE, Comparison
from .models import MODELS
from .strips import ENLARGED, save_strip
from .subjects import GREY

INTRODUCTION = """\
# The light of many bounces: five ways to have it, and path tracing

Written by `make compare ARGS=--update-docs`; every figure is from that run.

Two scenes under a white sky, without a sun: the ruin of `make demo`, and a deep box that is open to the front. Cycles
path traces them with {bounces} bounces and {samples} samples a pixel, diffuse surfaces, nothing clamped or denoised.
The same scenes are baked with {rays} rays a point, to vertices and to textures of {size} x {size}. Node groups turn the
bake into E/E0, the light of all bounces as a part of the unoccluded light. Base color times E/E0 is the shade that is
compared: same camera, same pixel filter, {model_samples} samples a pixel.

| model | what it knows of a point |
|---|---|
{models}

Differences are of linear RGB from the path-traced picture, over all pixels that surfaces cover wholly; 1 is a white
surface under the open sky. *Noise* is what the path tracing itself is off on average, from two halves of its samples.
In the pictures the lower row is the difference, {enlarged} times enlarged: the middle gray is none, lighter is too
bright, and a tint is a tint that is too much.
"""

GREY_PART = """\
## One albedo of {grey} everywhere

{pictures}

{table}

All that light meets has the albedo that the models assume, so this is a test of the bounces alone. Plain AO is too dark
by the light of all bounces. The published fit, which was made on one brick wall, is about as far off to the other side:
too bright wherever it is deep. The surface curve gets most of it right from plain AO and one number (the mean k_A of
what blocks the rays: {opennesses}). The baked channels and radiosity do not see the difference between a niche and a
crevice either, they need not: they have measured it.

What is left in the ruin are places where the bake has too few points, not bounces: dark rims where vertices lie buried
in another object and their value is drawn out over its edge, light lines in creases narrower than the mesh or its
texels. The heaps of rubble beside the first are instances, which show the first one's bake.
"""

COLOUR_PART = """\
## Their own colors

{pictures}

{table}

Now neighbors have other colors than the point itself. All models but radiosity take the neighbors' albedo for the
point's own: white stone beside the red wall gets no red, and the saturated walls get back only their own color, which
is too saturated and, for light colors, too bright. Radiosity has the colors of all that it sees, and stays as near as
in gray. It costs the freedom to change a base color after the bake.
"""

CURVES_PART = """\
## Curves of AO on fifteen surfaces

rms error of E/E0 against 40 simulated bounces, over eight height maps and seven meshes, all weighing alike
(`make bench ARGS=curves` has each of them). What is fitted is fitted to the other fourteen.

{table}

*The mean of all others* is the best that any function of that one value can do on a surface that it does not know.
"""

CHOICE_PART = """\
## Which one to take

- **Baked channels** (`bounces = 'BAKED'`, the default): right in every place, for any base color that is about its
  neighbors' own. The color may change after the bake, as in a game.
- **Radiosity** (`'RADIOSITY'`): right where colors bleed too. For what keeps its colors: still pictures, light baked
  for good. It is what the others are judged by without a path tracer.
- **Surface curve** (`core.multibounce.surface_curve`): where all there is is an AO map of k_A, such as another
  program's. It needs the mean of the same map, and no bake of ours.
- **Published fit** (`'FITTED'`): for relief like that of the wall that it was made on. `Fit Bounce Curves` fits the
  forms to a surface of your own, which takes most of the error away there (*refitted*, above).
- **No bounces**: for surfaces that are nearly black.
"""

CURVES = {
    "k_A": "no bounces: k_A alone",
    "published": "published fit of alpha",
    "refitted": "the same forms refitted",
    "cubic": "Jimenez et al. 2016, a cubic of k_A",
    "any of alpha": "mean of all others at that alpha",
    "any of k_A": "mean of all others at that k_A",
    "equal": "k_A / (1 - rho (1 - k_A))",
    "ours": "surface curve",
}


def write_page(comparisons: list[Comparison], rays: int, samples: int, folder: Path, root: Path) -> None:
    """Write `docs/bounces.md` under `root`, with the pictures of `comparisons`; `folder` is for what is on the way."""
    pictures = root / "docs" / "pictures"
    grey = [each for each in comparisons if not each.own_colours]
    colour = [each for each in comparisons if each.own_colours]
    for each in comparisons:
        shutil.copy(save_strip(each, folder), pictures)
    parts = [
        INTRODUCTION.format(
            bounces=BOUNCES, samples=samples, rays=rays, size=TEXTURE_SIZE, model_samples=MODEL_SAMPLES,
            enlarged=ENLARGED, models="\n".join(f"| {m.title} | {m.knows} |" for m in MODELS),
        ),
        GREY_PART.format(
            grey=f"{GREY:g}".lstrip("0"), pictures=_images(grey), table=_figures(grey),
            opennesses=" and ".join(f"{_short(each.openness, 2)} in the {each.subject.name}" for each in grey),
        ),
        COLOUR_PART.format(pictures=_images(colour), table=_figures(colour)),
        CURVES_PART.format(table=_curves(root)),
        CHOICE_PART,
    ]  # fmt: skip
    page = root / "docs" / "bounces.md"
    page.write_text("\n".join(parts), encoding="utf-8")
    print(f"wrote {page}")


def _images(comparisons: list[Comparison]) -> str:
    columns = ", ".join(model.title.lower() for model in MODELS)
    return "\n\n".join(
        f"![The {each.subject.name}: {columns}, path traced; below, how far each is off]"
        f"(pictures/bounces_{each.name}.jpg)"
        for each in comparisons
    )


def _short(value: float, digits: int = 4, sign: str = "") -> str:
    return f"{value:{sign}.{digits}f}".replace("0.", ".", 1)


def _figures(comparisons: list[Comparison]) -> str:
    heads = " | ".join(f"{each.subject.name}: mean \\|difference\\| | rms | bias" for each in comparisons)
    rows = [f"| | {heads} |", "|---|" + 3 * len(comparisons) * "--:|"]
    for model in MODELS:
        offs = [each.difference(model.name) for each in comparisons]
        cells = [f"{_short(off.absolute)} | {_short(off.rms)} | {_short(off.bias, sign='+')}" for off in offs]
        rows.append(f"| {model.title} | {' | '.join(cells)} |")
    rows.append(f"| *noise* | {' | '.join(f'{_short(each.noise)} | |' for each in comparisons)} |")
    return "\n".join(rows)


def _curves(root: Path) -> str:
    sys.path += [str(root), str(root / "tests" / "benchmarks")]
    curves, report = importlib.import_module("curves"), importlib.import_module("report").Report()
    report.begin("curves", curves.__doc__)
    curves.main(report, quick=False)
    ((_, _, figures),) = report.sections
    # The first figure says what the columns of all are.
    names = figures[0].what.split(": ")[1].split(" / ")
    measured = {figure.what: figure.measured.split(" / ") for figure in figures}
    means = [dict(zip(names, measured[f"albedo {rho}, all surfaces alike"], strict=True)) for rho in curves.ALBEDOS]
    heads = " | ".join(f"albedo {_short(rho, 1)}" for rho in curves.ALBEDOS)
    rows = [f"| | {heads} |", "|---|" + len(means) * "--:|"]
    rows += [f"| {title} | {' | '.join(each[name] for each in means)} |" for name, title in CURVES.items()]
    return "\n".join(rows)
