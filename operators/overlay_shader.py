# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders that draw over the meshes of the viewport."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import gpu
from mathutils import Matrix

# A hair before the surface itself.
_VERTEX = """
void main()
{
  gl_Position = ModelViewProjectionMatrix * vec4(position, 1.0);
  gl_Position.z -= 2e-5 * gl_Position.w;
  PASS_ON
}
"""


def overlay_shader(
    name: str,
    inputs: Mapping[str, str],
    fragment: str,
    constants: Mapping[str, str] | None = None,
    samplers: tuple[str, ...] = (),
) -> gpu.types.GPUShader:
    """A shader of vertices with a ``position`` and ``inputs``, types by name; its ``fragment`` source gets each as
    name_at and sets fragColor, in light, since the viewport's buffer encodes what is written to it for the display. It
    may read 2D ``samplers``, and ``constants``, types by name."""
    passed = gpu.types.GPUStageInterfaceInfo(name)
    info = gpu.types.GPUShaderCreateInfo()
    info.push_constant("MAT4", "ModelViewProjectionMatrix")
    for constant, kind in (constants or {}).items():
        info.push_constant(kind, constant)
    for slot, sampler in enumerate(samplers):
        info.sampler(slot, "FLOAT_2D", sampler)
    info.vertex_in(0, "VEC3", "position")
    for slot, (each, kind) in enumerate(inputs.items(), 1):
        info.vertex_in(slot, kind, each)
        passed.smooth(kind, f"{each}_at")
    info.vertex_out(passed)
    info.fragment_out(0, "VEC4", "fragColor")
    info.vertex_source(_VERTEX.replace("PASS_ON", " ".join(f"{each}_at = {each};" for each in inputs)))
    info.fragment_source(fragment)
    return gpu.shader.create_from_info(info)


@contextmanager
def placed(shader: gpu.types.GPUShader, matrix: Matrix) -> Iterator[None]:
    """In here the bound ``shader`` draws what ``matrix`` places in the world, in the view that is being drawn. It is
    multiplied onto Blender's own matrices, because drawing may set the uniform from those once more."""
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(matrix)
        whole = gpu.matrix.get_projection_matrix() @ gpu.matrix.get_model_view_matrix()
        shader.uniform_float("ModelViewProjectionMatrix", whole)
        yield
