"""Lamps by the thousand: small triangles that face down."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.rng import pcg4d, to_unit_interval
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.shapes import Mesh

BLACK = Lambertian((0.0, 0.0, 0.0))


def numbers(count: int) -> list[Scalars]:
    """Random numbers that are the same everywhere.

    Returns eight (count,) float64; in [0, 1).
    """
    keys = np.arange(count, dtype=np.uint32)
    zero = np.uint32(0)
    words = [*pcg4d(keys, zero, zero, zero), *pcg4d(keys, zero, zero, zero + 1)]  # type: ignore[arg-type]
    return [to_unit_interval(word) for word in words]


def lamps(centre: Vec3s, u: list[Scalars], brightest: float) -> tuple[Mesh, ...]:
    """Triangles of 5 to 20 mm, of many colours and powers; 64 of them.

    Parameters
    ----------
    centre : (L, 3) float64, m; where they hang
    u : list of (L,) float64
        Random numbers, of which 3 to 5 are used: size, strength and colour.
    brightest : float, W/(m² sr); radiance of the strongest
    """
    size = (0.005 + 0.015 * u[3])[:, None, None]
    # Facing down: counter-clockwise seen from below.
    triangle = np.array([[1.0, 0, 0], [-0.5, 0, 0.866], [-0.5, 0, -0.866]])
    vertices = centre[:, None] + size * triangle
    strength = brightest * u[4] ** 2
    colors = [
        (float(s * (1 - 0.8 * r)), float(s * 0.6), float(s * (0.2 + 0.8 * r)))
        for s, r in zip(strength, u[5], strict=True)
    ]
    # Lamps of one colour share a mesh: 64 colours, so that the file stays a function.
    bucket = np.arange(len(centre)) % 64
    return tuple(
        Mesh(
            name=f"lamps {b}",
            vertices=vertices[bucket == b].reshape(-1, 3),
            faces=np.arange(3 * int((bucket == b).sum())).reshape(-1, 3),
            material=BLACK,
            emission=colors[b],
        )
        for b in range(64)
    )
