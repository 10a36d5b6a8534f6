# SPDX-License-Identifier: GPL-3.0-or-later
"""The mathematics and the rays: numpy in, numpy out, no Blender.

Data flows one way through these files::

    rays.py           triangles of everything that blocks light  ->  an Embree scene
    rasterise.py      UV triangles                               ->  texels and the triangles at the places of each
    sample_points.py  vertices, or texels' places                ->  positions and normals, a block at a time
    sampling.py       how many rays                              ->  one pattern of weighted directions, turned a point
    light_cache.py    occluders + some of the points             ->  the light that surfaces around them send back
    visibility.py     occluders + points + pattern + cache       ->  F0, alpha, mean visible direction, light gathered
    multibounce.py    F0 and alpha, or F0, F1, F2, T             ->  the light after many bounces
    channels.py       all of those                               ->  the eight numbers a bake leaves

The light cache: ``cells.py`` (which piece of a surface a hit lies on) by ``key_table.py``, ``cell_rays.py`` (what cells
see), ``bounces.py`` (sums over that), ``final_gather.py`` (what points get from it).

Curves of AO: ``height_map.py`` or a mesh -> ``simulation.py`` (all bounces between its points) -> ``bounce_curves.py``
(means against AO, coefficients that fit them) -> ``curve_plot.py`` by ``plot.py``, ``canvas.py``, ``stroke_font.py``;
``area_mean.py`` scales maps down.

AO fields: ``field_hull.py``, ``field_rays.py`` (what an object blocks, seen from around it) -> ``field_fit.py``,
``field_inside.py`` -> ``ao_field.py`` (its evaluation) by ``cubemap.py`` and ``cap.py``; ``field_bake.py`` does it all,
``field_files.py`` keeps it, ``field_combine.py`` takes several together.

The World's light: ``spherical_harmonics.py``, ``clipped_cone.py`` -> ``bent_cone.py``; ``specular_occlusion.py``.

Beside them ``albedo.py`` (base colours of what blocks light), ``surroundings.py`` (points on what stands around a
simulated mesh), ``surface.py`` (triangles and their corners), ``scan_conversion.py`` and ``texel_rim.py`` (parts of the
rasteriser), ``mesh_parts.py`` (triangles as embreex takes them), ``morton.py`` (points along a curve), ``workers.py``
(threads), ``margin.py`` and ``exr.py``.
"""
