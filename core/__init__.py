# SPDX-License-Identifier: GPL-3.0-or-later
"""The mathematics and the rays: numpy in, numpy out, no Blender.

Data flows one way through these files::

    rays.py        triangles of everything that blocks light  ->  an Embree scene
    rasterise.py   UV triangles                               ->  texels and the surface points under them
    sampling.py    how many rays                              ->  one pattern of directions with weights, turned a point
    visibility.py  occluders + points + pattern               ->  F0, alpha and the mean visible direction of each point
    multibounce.py F0 and alpha                               ->  the light after many bounces
    channels.py    all of those                               ->  the eight numbers a bake leaves

beside them ``surface.py`` (points on triangles), ``morton.py``, ``margin.py`` and ``exr.py``.
"""
