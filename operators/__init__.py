# SPDX-License-Identifier: GPL-3.0-or-later
"""The only room that reads and writes Blender's data.

The doors: bake.py, clear.py, add_nodes.py with ``openness``, fit_bounces.py, with ``settings``, ``overrides`` and
           ``poll``;
           command_line.py with ``command_bake``, ``command_merge``, ``command_fit`` and what these share, in
           ``command_scene``.
The bake:  bake_job.py, which passes data through
    in     ``object_checks``, ``mesh_reader``, ``occluder_reader`` into ``occluder_scenes`` by ``occluder_cache``,
           ``uv_layout``, ``nearest_point``
    rays   ``vertex_target`` or ``texture_target``, by ``tracer``
    out    attributes, ``images``, ``bake_record``, ``object_materials`` with ``material_nodes``, ``report``
    shown  ``preview`` while it goes on, by ``preview_overlay``; by ``view_result`` later; both by ``overlay_shader``
The fit:   fit_job.py: ``fit_sources`` with ``occluder_scenes``, the simulation, ``curve_outputs`` and the node group
The World: project_world.py: ``world_radiance``, the node group, and ``material_nodes``; ``command_world``
The field: field_job.py: core's bake, ``field_outputs``, ``field_record`` on the object; field_receivers.py puts it into
           materials by ``field_nodes`` and takes it out; the doors bake_field.py, apply_field.py, ``command_field``
"""
