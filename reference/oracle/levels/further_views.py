"""Cases of what pixels look at, now and in the last frame."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, normalize
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.levels.draws import unit_vectors
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
ASLANT = Camera(
    (-2.1, 1.2, 3.0),
    (0.4, 0.1, -1.0),
    (0.0, 0.9, 0.3),
    40.0,
    width=50,
    height=20,
)
"""Of as many pixels as the other."""

LINE = Camera(
    (0.6, 1.1, 2.4),
    (-0.3, 0.2, -0.7),
    (0.2, 0.7, -0.4),
    100.0,
    width=499,
    height=1,
)
"""Of one line, and of an odd width."""

STRICT: dict[str, Value] = {"max_angle": 10.0, "max_depth": 0.02}
LOOSE: dict[str, Value] = {"max_angle": 60.0, "max_depth": 0.4}

FAR = Camera(
    (1024.5, -300.2, 77.0),
    (1000.0, -290.0, 50.0),
    (0.0, 0.8, 0.1),
    width=4096,
    height=2048,
)


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


def gbuffer_cases(rng: np.random.Generator) -> Iterator[Parts]:
    """Triangles in front of pixels: ordinary ones, then the extremes."""
    yield "gbuffer", _settings(CAMERA), _in_front(rng, CAMERA)
    yield "gbuffer-line", _settings(LINE), _in_front(rng, LINE)

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


def _in_front(rng: np.random.Generator, camera: Camera) -> dict[str, Any]:
    """Triangles of all sizes in front of every pixel; a tenth behind the camera."""
    rows = camera.width * camera.height
    reach = 2.0 ** rng.uniform(-2, 6, rows) * np.where(rng.random(rows) < 0.1, -1, 1)
    size = np.abs(reach) * 2.0 ** rng.uniform(-6, 1, rows)
    first, second = (unit_vectors(rng, rows) * size[:, None] for _ in range(2))
    u, v = rng.uniform(-0.2, 0.8, (2, rows))
    return _triangles(camera, np.arange(rows), reach, (first, second), u, v)


def reproject_cases(rng: np.random.Generator) -> Iterator[Parts]:
    """Points of this frame and what the last one saw: ordinary ones, then extremes."""
    yield "reproject", *_before(rng, CAMERA, SIMILARITY)
    yield "reproject-aslant", *_before(rng, ASLANT, STRICT)
    yield "reproject-line", *_before(rng, LINE, LOOSE)

    # At rest; half a pixel aside, on the borders; and about the pinhole itself.
    settings = _settings(CAMERA) | SIMILARITY
    depth = 10.0 ** rng.uniform(-1, 2, ROWS)
    x, y = pixel_centers(WIDTH, HEIGHT)
    aside = np.arange(ROWS) % 4
    position = _places(CAMERA, x + 0.5 * (aside % 2), y + 0.5 * (aside // 2), depth)
    small = 10.0 ** rng.uniform(-9, 0, ROWS)[:, None] * unit_vectors(rng, ROWS)
    at_eye = np.arange(ROWS) % 10 == 9
    eye = np.array(CAMERA.position)
    position = np.where(at_eye[:, None], eye + small, position)
    one = np.tile(unit_vectors(rng, 1), (ROWS, 1))
    inputs = {"position": position, "normal": one, "hit": np.ones(ROWS, np.uint32)}
    before = {"normal_before": one, "depth_before": depth}
    yield "reproject-borders", settings, inputs | before

    # All alike, so that the place alone decides; left of the image, right of it and
    # above, not below, where a row that is too large has no end.
    x, y = rng.uniform(-2, WIDTH + 2, ROWS), rng.uniform(-2, HEIGHT - 2, ROWS)
    x[::8] = rng.uniform(WIDTH, WIDTH + 1, len(x[::8]))
    z = rng.uniform(9.9, 10.1, ROWS)
    inputs = {
        "position": _places(CAMERA, x, y, z),
        "normal": one,
        "hit": np.ones(ROWS, np.uint32),
    }
    before = {"normal_before": one, "depth_before": np.full(ROWS, 10.0)}
    yield "reproject-beside", settings, inputs | before


def _places(camera: Camera, x: Scalars, y: Scalars, z: Scalars) -> Vec3s:
    """Points at places of the image and depths, (N, 3) m."""
    origin, d = camera_rays(camera, x, y)
    along = d @ camera.axes[2]
    position: Vec3s = origin + d * (z / along)[:, None]
    return position


def _before(
    rng: np.random.Generator, camera: Camera, similarity: dict[str, Value]
) -> tuple[dict[str, Value], dict[str, Any]]:
    """Settings and inputs of what a camera saw before, and of points about it."""
    width, height = camera.width, camera.height
    rows = width * height
    depth = 10.0 ** rng.uniform(-1, 2, rows)
    normal = unit_vectors(rng, rows)
    depth_before = depth * (rng.random(rows) < 0.95)
    x = rng.uniform(-1.6, width + 1.6, rows)
    y = rng.uniform(-1.6, height + 1.6, rows)
    # Not right of the last line, where a row that is too large has no end.
    x = np.where((x >= width) & (y >= height - 1), x - width, x)
    column, line = (
        np.clip(np.floor(v), 0, most - 1).astype(int)
        for v, most in ((x, width), (y, height))
    )
    row = line * width + column
    # A tenth is as near as what was seen allows, and nearer than its own depth does.
    most = float(similarity["max_depth"])
    edge = 1 - rng.uniform(most / (1 + most), most, rows)
    beside = rng.uniform(1 - 1.4 * most, 1 + 1.4 * most, rows)
    z = depth[row] * np.where(rng.random(rows) < 0.1, edge, beside)
    z *= np.where(rng.random(rows) < 0.1, -1, 1)
    spread = 0.7 * np.radians(float(similarity["max_angle"]))
    near = normal[row] + spread * rng.normal(size=(rows, 3))
    inputs = {
        "position": _places(camera, x, y, z),
        "normal": normalize(near),
        "hit": (rng.random(rows) < 0.9).astype(np.uint32),
        "normal_before": normal,
        "depth_before": depth_before,
    }
    return _settings(camera) | similarity, inputs
