# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes with known visibility: (vertices (n, 3), triangles (m, 3)), fronts counter-clockwise."""

import numpy as np


def quad(a, b, c, d):
    """Corners in counter-clockwise order, seen from the front."""
    return np.array([a, b, c, d], float), np.array([[0, 1, 2], [0, 2, 3]])


def plate(half=1.0, z=0.0):
    """A square in the plane z, facing up."""
    return quad((-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z))


def box(half=1.0):
    """A closed cube about the origin, facing out."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float) * half
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return corners, np.array(triangles)


def sphere(radius=1.0, centre=(0.0, 0.0, 0.0), rings=192):
    """A latitude-longitude sphere, facing out, with the volume of the true one to about (pi / rings)^2."""
    theta = np.linspace(0.0, np.pi, rings + 1)
    phi = np.arange(2 * rings) * (np.pi / rings)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    points = np.stack((np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)), axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rings), np.arange(2 * rings), indexing="ij")
    a, b = (i * 2 * rings + j).ravel(), (i * 2 * rings + (j + 1) % (2 * rings)).ravel()
    c, d = b + 2 * rings, a + 2 * rings
    triangles = np.concatenate((np.stack((a, d, c), 1), np.stack((a, c, b), 1)))
    return np.asarray(centre) + radius * points, triangles


def bumpy(side=90, height=0.35):
    """A wavy, self-occluding height field over [-1, 1]^2, facing up, with its vertex normals."""
    x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side), indexing="ij")
    z = height * np.sin(7.0 * x + 1.0) * np.cos(6.0 * y) + 0.1 * np.sin(17.0 * x * y)
    vertices = np.stack((x, y, z), axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(side - 1), np.arange(side - 1), indexing="ij")
    a = (i * side + j).ravel()
    triangles = np.concatenate((np.stack((a, a + side, a + side + 1), 1), np.stack((a, a + side + 1, a + 1), 1)))
    return vertices, triangles


def vertex_normals(vertices, triangles):
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    face = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for corner in triangles.T:
        np.add.at(normals, corner, face)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def join(*meshes):
    vertices, triangles, count = [], [], 0
    for points, faces in meshes:
        vertices.append(points)
        triangles.append(faces + count)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(triangles)
