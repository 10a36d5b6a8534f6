# SPDX-License-Identifier: GPL-3.0-or-later
"""Spherical harmonics to order 2 against the integrals that define them."""

import numpy as np
import pytest

from core import spherical_harmonics as sh

COLOUR = np.array((1.0, 0.5, 2.0))


def quadrature(rings=16):
    """Directions (n, 3) and weights (n,) that integrate polynomials of degree 2 ``rings`` - 1 exactly."""
    z, weight = np.polynomial.legendre.leggauss(rings)
    azimuth = 2.0 * np.pi * np.arange(2 * rings) / (2 * rings)
    z, azimuth = np.meshgrid(z, azimuth, indexing="ij")
    across = np.sqrt(1.0 - z * z)
    directions = np.stack((across * np.cos(azimuth), across * np.sin(azimuth), z), axis=-1)
    return directions.reshape(-1, 3), np.repeat(weight * np.pi / rings, 2 * rings)


def random_directions(count, seed=0):
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def random_rotation(seed=0):
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turn * np.linalg.det(turn)


def test_basis_is_orthonormal():
    directions, weights = quadrature()
    gram = sh.project(sh.basis(directions), directions, weights)
    error = np.abs(gram - np.eye(9)).max()
    print(f"projections of the basis functions: within {error:.1e}")
    assert error < 1e-6


def test_published_constants():
    """Ramamoorthi and Hanrahan 2001, eq. (3), to the digits that they print."""
    x, y, z = w = random_directions(1)[0]
    printed = (
        *(0.282095, 0.488603 * y, 0.488603 * z, 0.488603 * x, 1.092548 * x * y, 1.092548 * y * z),
        *(0.315392 * (3 * z * z - 1), 1.092548 * x * z, 0.546274 * (x * x - y * y)),
    )
    np.testing.assert_allclose(sh.basis(w), printed, atol=2e-6)


def test_delta():
    """A light in one direction w: L_lm = Y_lm(w), and its irradiance follows the lobe that order 2 leaves of the
    cosine, (1 + 2 cos + 5/8 (3 cos^2 - 1)) / 4."""
    w = random_directions(1, seed=3)
    coefficients = sh.project(np.ones(1), w, np.ones(1))
    np.testing.assert_allclose(coefficients, sh.basis(w[0]), atol=1e-12)
    normals = random_directions(50, seed=4)
    cos = normals @ w[0]
    expected = (1.0 + 2.0 * cos + 5.0 / 8.0 * (3.0 * cos**2 - 1.0)) / 4.0 / np.pi
    np.testing.assert_allclose(sh.irradiance(coefficients, normals), expected, atol=1e-12)


def test_cosine_lobe():
    """max(cos, 0) about an axis: L_lm = A_l Y_lm(axis). Integrated over its own hemisphere, where it is smooth."""
    turn = random_rotation(1)
    z, weight = np.polynomial.legendre.leggauss(8)
    z, weight = (z + 1) / 2, weight / 2
    azimuth = np.arange(16) * np.pi / 8
    z, azimuth = np.meshgrid(z, azimuth, indexing="ij")
    across = np.sqrt(1.0 - z * z)
    local = np.stack((across * np.cos(azimuth), across * np.sin(azimuth), z), axis=-1).reshape(-1, 3)
    coefficients = sh.project(local[:, 2], local @ turn.T, np.repeat(weight, 16) * np.pi / 8)
    expected = np.repeat((np.pi, 2 * np.pi / 3, np.pi / 4), (1, 3, 5)) * sh.basis(turn[:, 2])
    error = np.abs(coefficients - expected).max()
    print(f"projection of a cosine lobe: within {error:.1e}")
    assert error < 1e-6


def test_irradiance_is_the_integral():
    """Band-limited light, in colour, against quadrature over the hemisphere."""
    rng = np.random.default_rng(5)
    coefficients = rng.normal(size=(9, 3))
    z, weight = np.polynomial.legendre.leggauss(8)
    for normal in random_directions(5, seed=6):
        turn = np.linalg.qr(np.column_stack((normal, rng.normal(size=(3, 2)))))[0]
        axis = turn[:, 0] * np.sign(turn[:, 0] @ normal)
        total = np.zeros(3)
        for height, w in zip((z + 1) / 2, weight / 2, strict=True):
            azimuth = np.arange(16)[:, None] * np.pi / 8
            ring = np.sqrt(1 - height**2) * (np.cos(azimuth) * turn[:, 1] + np.sin(azimuth) * turn[:, 2])
            total += w * np.pi / 8 * (height * sh.evaluate(coefficients, ring + height * axis)).sum(axis=0)
        np.testing.assert_allclose(sh.irradiance(coefficients, normal), total / np.pi, atol=1e-9)


def test_white_light_is_1_everywhere():
    white = sh.project_panorama(np.ones((32, 64, 3)))
    np.testing.assert_allclose(sh.irradiance(white, random_directions(20)), 1.0, atol=1e-3)


def test_panorama():
    """Each basis function painted as a picture comes back, to the picture's resolution; colours stay apart."""
    directions, solid_angles = sh.equirectangular(256, 512)
    assert solid_angles.sum() == pytest.approx(4 * np.pi, rel=1e-12)
    pixels = sh.basis(directions)
    error = np.abs(sh.project_panorama(pixels) - np.eye(9)).max()
    print(f"basis functions as pictures of 512 x 256: within {error:.1e}")
    assert error < 1e-4
    coloured = sh.project_panorama(pixels[..., 3, None] * COLOUR)
    np.testing.assert_allclose(coloured[3], COLOUR, rtol=1e-4)


def test_panorama_lies_as_blender_has_it():
    directions, _ = sh.equirectangular(180, 360)
    np.testing.assert_allclose(directions[0].mean(axis=0), (0, 0, -1), atol=1e-2)
    np.testing.assert_allclose(directions[90, 180], (1, 0, 0), atol=2e-2)
    np.testing.assert_allclose(directions[90, 90], (0, 1, 0), atol=2e-2)


def test_rotation():
    """It turns the light, keeps its power in each band, and is undone by the inverse."""
    coefficients, turn = np.random.default_rng(7).normal(size=(9, 3)), random_rotation(8)
    turned = sh.rotate(coefficients, turn)
    w = random_directions(50, seed=9)
    np.testing.assert_allclose(sh.evaluate(turned, w @ turn.T), sh.evaluate(coefficients, w), atol=1e-12)
    matrix = sh.rotate(np.eye(9), turn)
    error = np.abs(matrix @ matrix.T - np.eye(9)).max()
    print(f"rotation: orthonormal within {error:.1e}")
    assert error < 1e-12
    assert (matrix[sh.BAND[:, None] != sh.BAND] == 0).all()
    np.testing.assert_allclose(sh.rotate(turned, turn.T), coefficients, atol=1e-12)


def test_polynomial():
    coefficients = np.random.default_rng(10).normal(size=(9, 3))
    light, w = sh.polynomial(coefficients), random_directions(1)[0]
    value = light.mean + w @ light.slope + np.einsum("i,ijc,j->c", w, light.curve, w)
    np.testing.assert_allclose(value, sh.evaluate(coefficients, w), atol=1e-12)
    np.testing.assert_allclose(np.einsum("iic->c", light.curve), 0, atol=1e-12)
    np.testing.assert_allclose(sh.from_polynomial(light), coefficients, atol=1e-12)
