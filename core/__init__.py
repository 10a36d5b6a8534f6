# SPDX-License-Identifier: GPL-3.0-or-later
"""The mathematics and the rays: numpy in, numpy out, no Blender.

Data flows one way through these files::

    rays.py           triangles of everything that blocks light  ->  an Embree scene
    rasterise.py      UV triangles                               ->  texels and the triangles at the places of each
    sample_points.py  vertices, or texels' places                ->  positions and normals, a block at a time
    sampling.py       how many rays                              ->  one pattern of weighted directions, turned a point
    visibility.py     occluders + points + pattern               ->  F0, alpha and the mean visible direction
    multibounce.py    F0 and alpha                               ->  the light after many bounces
    channels.py       all of those                               ->  the eight numbers a bake leaves

beside them ``surface.py`` (triangles and their corners), ``scan_conversion.py`` and ``texel_rim.py`` (parts of the
rasteriser), ``morton.py`` (points along a curve), ``workers.py`` (threads), ``margin.py`` and ``exr.py``.
"""
