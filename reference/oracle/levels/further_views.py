"""Cases of what pixels look at, now and in the last frame."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, normalize
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.scene.camera import Camera, camera_rays, pixel_centers

# Name, settings and inputs of a case.
Parts = tuple[str, dict[str, Value], dict[str, Any]]

WIDTH, HEIGHT = 40, 25
ROWS = WIDTH * HEIGHT
SIMILARITY: dict[str, Value] = {"max_angle": 25.0, "max_depth": 0.05}

CAMERA = Camera(
    (1.3, 2.6, -3.7),
    (0.25, 0.5, 2.0),
    (0.1, 1.0, 0.0),
    65.0,
    width=WIDTH,
    height=HEIGHT,
)
FAR = Camera((1024.5, -300.2, 77.0), (1000.0, -290.0, 50.0), width=4096, height=2048)


def _settings(camera: Camera) -> dict[str, Value]:
    vectors = (("eye", camera.position), ("target", camera.target), ("up", camera.up))
    found: dict[str, Value] = {
        f"{name}_{axis}": v
        for name, vector in vectors
        for axis, v in zip("xyz", vector, strict=True)
    }
    return found | {
        "fov_x": camera.fov,
        "width": camera.width,
        "height": camera.height,
    }


def _triangles(
    camera: Camera,
    pixel: Scalars,
    reach: Scalars,
    edges: tuple[Vec3s, Vec3s],
    u: Scalars,
    v: Scalars,
) -> dict[str, Any]:
    """Triangles that the rays of pixels meet at barycentric coordinates u and v."""
    line, column = np.divmod(pixel, camera.width)
    origin, d = camera_rays(camera, column + 0.5, line + 0.5)
    a = origin + d * reach[:, None] - edges[0] * u[:, None] - edges[1] * v[:, None]
    return {"pixel": pixel, "a": a, "b": a + edges[0], "c": a + edges[1]}


def unit_vectors(rng: np.random.Generator, rows: int) -> Vec3s:
    """Directions, all alike, (N, 3); unit vectors."""
    return normalize(rng.normal(size=(rows, 3)))


def gbuffer_cases(rng: np.random.Generator) -> Iterator[Parts]:
    """Triangles in front of pixels: ordinary ones, then the extremes."""
    pixel = np.arange(ROWS)
    # A tenth behind the camera.
    reach = 2.0 ** rng.uniform(-2, 6, ROWS) * np.where(rng.random(ROWS) < 0.1, -1, 1)
    size = np.abs(reach) * 2.0 ** rng.uniform(-6, 1, ROWS)
    first, second = (unit_vectors(rng, ROWS) * size[:, None] for _ in range(2))
    u, v = rng.uniform(-0.2, 0.8, (2, ROWS))
    inputs = _triangles(CAMERA, pixel, reach, (first, second), u, v)
    yield "gbuffer", _settings(CAMERA), inputs

    # Corners of the image; rays through corners and edges; slivers, triangles seen
    # edge-on, and points in place of triangles; far from the origin.
    last = FAR.width * FAR.height - 1
    pixels = np.array([0, FAR.width - 1, last - FAR.width + 1, last, last // 2])
    across = unit_vectors(rng, 1)
    kinds = [
        (across, unit_vectors(rng, 1)),
        (across, across * 1.0001),
        (across, across * 0.0),
    ]
    place = [(0.0, 0.0), (0.5, 0.5), (0.0, 0.3), (0.3, 0.3), (0.3, -1e-6), (0.6, 0.6)]
    rows = list(product(pixels, range(len(kinds)), place, (1e-3, 1.0, 1e3)))
    pixel = np.array([row[0] for row in rows])
    kind = [row[1] for row in rows]
    u, v = np.array([row[2] for row in rows]).T
    reach = np.array([row[3] for row in rows])
    edges = [np.concatenate([kinds[k][side] for k in kind]) for side in (0, 1)]
    inputs = _triangles(FAR, pixel, reach, (edges[0], edges[1]), u, v)
    yield "gbuffer-extremes", _settings(FAR), inputs


def reproject_cases(rng: np.random.Generator) -> Iterator[Parts]:
    """Points of this frame and what the last one saw: ordinary ones, then extremes."""
    depth = 10.0 ** rng.uniform(-1, 2, ROWS)
    normal = unit_vectors(rng, ROWS)
    depth_before = depth * (rng.random(ROWS) < 0.95)

    def points(x: Scalars, y: Scalars, z: Scalars) -> Vec3s:
        origin, d = camera_rays(CAMERA, x, y)
        along = d @ CAMERA.axes[2]
        position: Vec3s = origin + d * (z / along)[:, None]
        return position

    x, y = rng.uniform(-3, WIDTH + 3, ROWS), rng.uniform(-3, HEIGHT + 3, ROWS)
    column, line = (
        np.clip(np.floor(v), 0, most - 1).astype(int)
        for v, most in ((x, WIDTH), (y, HEIGHT))
    )
    row = line * WIDTH + column
    z = depth[row] * rng.uniform(0.93, 1.07, ROWS)
    z *= np.where(rng.random(ROWS) < 0.05, -1, 1)
    near = normal[row] + 0.2 * rng.normal(size=(ROWS, 3))
    hit = (rng.random(ROWS) < 0.95).astype(np.uint32)
    before = {"normal_before": normal, "depth_before": depth_before}
    settings = _settings(CAMERA) | SIMILARITY
    inputs = {"position": points(x, y, z), "normal": normalize(near), "hit": hit}
    yield "reproject", settings, inputs | before

    # At rest; half a pixel aside, on the borders; and about the pinhole itself.
    x, y = pixel_centers(WIDTH, HEIGHT)
    aside = np.arange(ROWS) % 4
    position = points(x + 0.5 * (aside % 2), y + 0.5 * (aside // 2), depth)
    small = 10.0 ** rng.uniform(-9, 0, ROWS)[:, None] * unit_vectors(rng, ROWS)
    at_eye = np.arange(ROWS) % 10 == 9
    eye = np.array(CAMERA.position)
    position = np.where(at_eye[:, None], eye + small, position)
    one = np.tile(normal[:1], (ROWS, 1))
    inputs = {"position": position, "normal": one, "hit": np.ones(ROWS, np.uint32)}
    before = {"normal_before": one, "depth_before": depth}
    yield "reproject-borders", settings, inputs | before

    # All alike, so that the place alone decides; left of the image, right of it and
    # above, not below, where a row that is too large has no end.
    rng = np.random.default_rng(2028)
    x, y = rng.uniform(-2, WIDTH + 2, ROWS), rng.uniform(-2, HEIGHT - 2, ROWS)
    z = rng.uniform(9.9, 10.1, ROWS)
    inputs = {
        "position": points(x, y, z),
        "normal": one,
        "hit": np.ones(ROWS, np.uint32),
    }
    before = {"normal_before": one, "depth_before": np.full(ROWS, 10.0)}
    yield "reproject-beside", settings, inputs | before
