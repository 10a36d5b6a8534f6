# SPDX-License-Identifier: GPL-3.0-or-later
"""The only room that reads and writes Blender's data.

bake.py, clear.py, add_nodes.py and command_line.py are the doors; bake_job.py is the bake itself, from
``object_checks``, ``occluder_scenes`` and ``mesh_reader`` (in) to ``vertex_target``, ``texture_target`` and
``object_materials`` (out).
"""
