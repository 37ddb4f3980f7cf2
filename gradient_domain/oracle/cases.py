"""Cases of pairs and images: tables made here, without a scene, the same for a seed."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from restir_gi.gradient_domain.oracle.contract import BY_CHANNELS, EITHER_SIDE, GIVEN
from restir_gi.gradient_domain.oracle.edges import PixelLikeness
from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.draws import about, ends_of_u, unit_vectors
from restir_gi.reference.oracle.parts import SEED

ROWS, SLOTS = 256, 3
FIXED = PixelLikeness()
ALONE, NULL, EMPTY, LOST, STRANGE = 0.3, 0.2, 0.1, 0.2, 0.25
"""Shares of base paths without offset path, of reservoirs without sample, of slots
without source and of sources with M = 0, of outer shifts that fail, and of samples that
another source could not have made."""

NEAR = 2.0**-16
"""Just above and below a threshold: far more than either type rounds."""

SIGNS = ("plus", "minus", "both")
SCALES = (("", 1.0), ("-dim", 1e-5), ("-bright", 1e5))

Tables = dict[str, Any]


def pair_cases(precision: Precision, seed: int = SEED) -> list[Case]:
    """Cases of all passes, in the contract's order.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        In which the inputs are given: numbers that float32 holds.
    seed : int; of all tables
    """
    rng = np.random.default_rng([2031, seed])
    found = [
        *_of_samples(rng),
        *_of_shifts(rng),
        *_of_reuse(rng),
        *_of_estimates(rng),
        *_of_pixels(rng),
        *_of_colors(rng),
        *_of_solvers(rng),
    ]
    return [_case(*one, precision) for one in found]


def declared_cases(precision: Precision, seed: int = SEED) -> list[Case]:
    """Cases with values of settings that have to be declared.

    Parameters
    ----------
    precision : 'float32' or 'float64'; as for `pair_cases`
    seed : int; of all tables
    """
    rng = np.random.default_rng([2033, seed])
    found = [*_of_likeness(rng), *_of_channels(rng)]
    return [_case(*one, precision) for one in found]


_Asked = tuple[str, str, dict[str, Value], Tables, bool]
"""Name, pass, settings, buffers, and whether decisions are random."""


def _case(
    name: str,
    pass_name: str,
    settings: dict[str, Value],
    inputs: Tables,
    random: bool,
    precision: Precision,
) -> Case:
    held = {
        n: v.astype(np.float32) if v.dtype.kind == "f" else v for n, v in inputs.items()
    }
    width = settings.get("width")
    return Case(
        name,
        pass_name,
        settings=settings,
        inputs=given(held, precision),
        random=random,
        width=int(width) if pass_name in IMAGES and width else None,
    )


IMAGES = ("pair_search", "pair_differences", "differences", "poisson_l2", "poisson_l1")

# ------------------------------------------------ samples


def _lit(rng: Generator, shape: tuple[int, ...], scale: float) -> Vec3s:
    """Colours, a few of one channel alone; never black."""
    found: Vec3s = scale * 10.0 ** rng.normal(0, 0.6, (*shape, 3))
    dark = rng.random((*shape, 3)) < 0.08
    dark[..., 1] &= ~(dark[..., 0] & dark[..., 2])
    found[dark] = 0.0
    return found


def _values(rng: Generator, shape: tuple[int, ...], scale: float) -> Tables:
    """Base paths, offset paths that are alike or not, and none at all."""
    base = _lit(rng, shape, scale)
    alike = base * 10.0 ** rng.normal(0, 0.15, (*shape, 3))
    near = rng.random(shape) < 0.5
    offset = np.where(near[..., None], alike, _lit(rng, shape, scale))
    inner = 10.0 ** rng.normal(0, 0.4, shape)
    alone = rng.random(shape) < ALONE
    return {
        "base": base,
        "offset": np.where(alone[..., None], 0.0, offset),
        "inner": np.where(alone, 0.0, inner),
    }


def _samples(rng: Generator, shape: tuple[int, ...], scale: float) -> Tables:
    k = rng.integers(0, 2, shape).astype(np.uint32)
    return {"k": k} | _values(rng, shape, scale)


def _of_samples(rng: Generator) -> Iterator[_Asked]:
    for word, scale in SCALES:
        yield (
            f"pair-value{word}",
            "pair_value",
            {},
            _samples(rng, (ROWS,), scale),
            False,
        )
    yield "pair-weight", "pair_weight", {}, _densities(rng), False
    for sign in SIGNS:
        for word, scale in SCALES:
            tables = _samples(rng, (ROWS,), scale)
            yield (
                f"pair-target-{sign}{word}",
                "pair_target",
                {"sign": sign},
                tables,
                False,
            )
        name = f"pair-initial-{sign}"
        yield name, "pair_initial", {"sign": sign}, _candidates(rng, 1.0), True
    for word, scale in SCALES[1:]:
        settings: dict[str, Value] = {"sign": "plus"}
        yield (
            f"pair-initial{word}",
            "pair_initial",
            settings,
            _candidates(rng, scale),
            True,
        )


def _densities(rng: Generator) -> Tables:
    """With densities that are 0, and Jacobians far from 1."""
    p = 10.0 ** rng.uniform(-3, 3, (2, ROWS))
    inner = 10.0 ** rng.uniform(-2, 2, ROWS)
    p[0, ::7], p[1, 3::9], inner[::5] = 0.0, 0.0, 0.0
    return {"p_base": p[0], "p_offset": p[1], "inner": inner}


def _candidates(rng: Generator, scale: float) -> Tables:
    """Of both pixels; one or both may be nulls."""
    W = 10.0 ** rng.normal(0, 0.5, (ROWS, 2))
    W[rng.random((ROWS, 2)) < NULL] = 0.0
    return _values(rng, (ROWS, 2), scale) | {"W": W, "u": ends_of_u(rng, ROWS)}


# ------------------------------------------------ shifts


def _ends(rng: Generator) -> Tables:
    """Rows of both pixels of pairs."""
    width = 40
    down = rng.integers(0, 2, ROWS)
    first = rng.integers(0, 1000, ROWS)
    return {
        "first": first.astype(np.int32),
        "second": (first + np.where(down == 1, width, 1)).astype(np.int32),
        "dx": 1.0 - down,
        "dy": 1.0 * down,
    }


def _shifted(rng: Generator, lost: float) -> tuple[Vec3s, Scalars]:
    """Values and Jacobians in both pixels; a shift that fails leaves what was there."""
    jacobian = 10.0 ** rng.normal(0, 0.5, (ROWS, 2))
    jacobian[rng.random((ROWS, 2)) < lost] = 0.0
    return _lit(rng, (ROWS, 2), 1.0), jacobian


def _of_shifts(rng: Generator) -> Iterator[_Asked]:
    k = rng.integers(0, 2, ROWS).astype(np.uint32)
    value, jacobian = _shifted(rng, ALONE)
    places = {axis: rng.uniform(0, 40, ROWS) for axis in "xy"}
    tables = {
        "k": k,
        **_ends(rng),
        **places,
        "value_at": value,
        "jacobian_at": jacobian,
    }
    yield "inner-shift", "inner_shift", {}, tables, False
    value, jacobian = _shifted(rng, LOST)
    rebuilt, inner = _shifted(rng, ALONE)
    rebuilt = np.where(inner[..., None] > 0, rebuilt, 0.0)
    ends = _ends(rng)
    tables = {
        "k": rng.integers(0, 2, ROWS).astype(np.uint32),
        "first": ends["first"],
        "second": ends["second"],
        "value_at": value,
        "jacobian_at": jacobian,
        "rebuilt_at": rebuilt,
        "inner_at": inner,
        "offset_from": _lit(rng, (ROWS,), 1.0),
        "inner_from": 10.0 ** rng.normal(0, 0.5, ROWS),
    }
    yield "outer-shift", "outer_shift", {}, tables, False


# ------------------------------------------------ reuse

WEIGHTS = ("1/M", "1/Z", "balance", "pairwise", "defensive")


def _of_reuse(rng: Generator) -> Iterator[_Asked]:
    for number, mis in enumerate(WEIGHTS):
        for other, canonical in enumerate((0, SLOTS - 1)):
            sign = SIGNS[(number + other) % 3]
            settings: dict[str, Value] = {
                "sign": sign,
                "mis": mis,
                "canonical": canonical,
                "cap": (30.0, 12.5)[other],
            }
            name = f"pair-reuse-{mis.replace('/', '-over-')}-{sign}"
            yield name, "pair_reuse", settings, _sources(rng, canonical, sign), True


def _has_part(s: Tables, sign: str) -> NDArray[np.bool_]:
    """Whether samples have a part of a sign: else no reservoir of it keeps them."""
    G = s["base"] - s["offset"] * s["inner"][..., None]
    G = np.where(s["k"][..., None] == 1, -G, G)
    G = {"plus": G, "minus": -G}.get(sign, np.abs(G))
    found: NDArray[np.bool_] = (1e-3 * s["base"] < G).any(axis=-1)
    return found


def _sources(rng: Generator, canonical: int, sign: str) -> Tables:
    """What K pairs bring, and what each could have made of the others' samples."""
    shape = (ROWS, SLOTS)
    there = rng.random(shape) > EMPTY
    empty = rng.random(shape) < EMPTY
    there[:, canonical], empty[:, canonical] = True, False
    made, here = _samples(rng, shape, 1.0), _values(rng, shape, 1.0)
    full = there & ~empty & (rng.random(shape) > NULL) & _has_part(made, sign)
    arrives = full & (rng.random(shape) > LOST)
    arrives[:, canonical] = full[:, canonical]
    for name, array in here.items():
        array[:, canonical] = made[name][:, canonical]
    jacobian = np.where(arrives, 10.0 ** rng.normal(0, 0.4, shape), 0.0)
    jacobian[:, canonical] = 1.0
    at = _values(rng, (*shape, SLOTS), 1.0)
    known = (rng.random((*shape, SLOTS)) > STRANGE) & arrives[:, :, None]
    jacobian_at = np.where(known, 10.0 ** rng.normal(0, 0.4, (*shape, SLOTS)), 0.0)
    return {
        "W": np.where(full, 10.0 ** rng.normal(0, 0.5, shape), 0.0),
        "M": np.where(empty, 0.0, rng.integers(1, 20, shape)),
        "there": there.astype(np.uint32),
        **{f"{name}_from": array for name, array in made.items()},
        **here,
        "jacobian": jacobian,
        **{f"{name}_at": array for name, array in at.items()},
        "jacobian_at": jacobian_at,
        "u": ends_of_u(rng, ROWS * SLOTS).reshape(shape),
    }


# ------------------------------------------------ estimates


def _kept(rng: Generator, samples: Tables) -> Tables:
    W = 10.0 ** rng.normal(0, 0.5, (ROWS, 2))
    W[rng.random((ROWS, 2)) < NULL] = 0.0
    return samples | {"W": W}


def _of_estimates(rng: Generator) -> Iterator[_Asked]:
    for count in ("two", "one"):
        for word, scale in SCALES[: 3 if count == "two" else 1]:
            tables = _kept(rng, _samples(rng, (ROWS, 2), scale))
            settings: dict[str, Value] = {"reservoirs": count}
            yield (
                f"pair-estimate-{count}{word}",
                "pair_estimate",
                settings,
                tables,
                False,
            )
    for word, scale in SCALES:
        tables = _kept(rng, _values(rng, (ROWS, 2), scale))
        yield f"after-estimate{word}", "after_estimate", {}, tables, False


# ------------------------------------------------ pixels


def _pixels(rng: Generator, size: int) -> Tables:
    """Of several walls: few albedos and directions, so that many pixels look alike."""
    walls = 6
    normals = unit_vectors(rng, walls)
    which = rng.integers(0, walls, size)
    return {
        "albedo": rng.choice([0.1, 0.25, 0.5, 0.8], (walls, 3))[which],
        "normal": normals[which],
        "depth": rng.choice([2.0, 2.15, 2.4, 3.0], size),
        "hit": (rng.random(size) > 0.1).astype(np.uint32),
    }


def _of_pixels(rng: Generator) -> Iterator[_Asked]:
    yield "edge-pair", "edge_pair", {}, _neighbors(rng), False
    yield "edge-pair-thresholds", "edge_pair", {}, _thresholds(rng), False
    for width, height, radius, tries in (
        (32, 24, 2, 12),
        (13, 37, 4, 20),
        (60, 1, 3, 8),
    ):
        name, settings = (
            f"pair-search-{width}x{height}",
            {"width": width, "radius": radius},
        )
        yield (
            name,
            "pair_search",
            {**settings},
            _walls(rng, width, height, tries),
            False,
        )
    for width, height in ((16, 20), (9, 40), (320, 1), (1, 320)):
        tables = _motions(rng, width, height)
        settings = {"width": width, "height": height}
        yield (
            f"pair-motion-{width}x{height}",
            "pair_motion",
            {**settings},
            tables,
            False,
        )


def _sides(a: Tables, b: Tables) -> Tables:
    named = {f"{name}_a": array for name, array in a.items()}
    return named | {f"{name}_b": array for name, array in b.items()}


def _neighbors(rng: Generator, like: PixelLikeness = FIXED) -> Tables:
    """Pixels of which one thing differs as a rule, and nothing very little."""
    a = _pixels(rng, ROWS * 3)
    b = {name: array.copy() for name, array in a.items()}
    turn = rng.integers(0, 5, ROWS * 3)
    color = np.clip(a["albedo"] + rng.uniform(-0.3, 0.3, a["albedo"].shape), 0.02, 1.0)
    # Of one channel, of two, or of all three.
    share = np.where(rng.random(ROWS * 3) < 0.4, 1.0, 0.4)[:, None]
    differs = (turn == 0)[:, None] & (rng.random(a["albedo"].shape) < share)
    b["albedo"] = np.where(differs, color, a["albedo"])
    limit, near = like.cosine, min(1 - like.cosine, 0.1)
    anywhere, ahead, behind = (
        rng.uniform(least, most, ROWS * 3)
        for least, most in ((-1, 1), (limit - near, limit + near), (-1, -limit))
    )
    cosine = np.choose(rng.integers(0, 3, ROWS * 3), [anywhere, ahead, behind])
    on = np.abs(np.abs(cosine) - limit) < 1e-3
    tilted = about(rng, a["normal"], np.where(on, 1.0, cosine))
    b["normal"] = np.where((turn == 1)[:, None], tilted, a["normal"])
    # Where quotients of depths by either one, or metres, would decide otherwise.
    around = 1 + like.depth * np.array([-1.05, -0.95, 0.6, 0.95, 1.05, 2.0])
    factor = rng.choice([0.5, 0.8, *around], ROWS * 3)
    a["depth"] = 10.0 ** rng.uniform(-1, 2, ROWS * 3)
    b["depth"] = np.where(turn == 2, factor, 1.0) * a["depth"]
    for side in (a, b):
        side["hit"] = (rng.random(ROWS * 3) > 0.25).astype(np.uint32)
    return _sides(a, b)


def _thresholds(rng: Generator, like: PixelLikeness = FIXED) -> Tables:
    """Just above and below each threshold, and on it, which is open or not."""
    a = _pixels(rng, ROWS)
    b = {name: array.copy() for name, array in a.items()}
    a["hit"] = b["hit"] = np.ones(ROWS, np.uint32)
    turn, aside = rng.integers(0, 3, ROWS), rng.choice([-NEAR, 0.0, NEAR], ROWS)
    channel, row = rng.integers(0, 3, ROWS), np.arange(ROWS)
    step = np.where(rng.random(ROWS) < 0.5, 1.0, -1.0) * (like.albedo + 1.6 * aside)
    a["albedo"] = np.full((ROWS, 3), 0.5)
    b["albedo"] = a["albedo"].copy()
    b["albedo"][row, channel] += np.where(turn == 0, step, 0.0)
    cosine = like.cosine * (1 + aside)
    if like.either_side:
        cosine = np.where(rng.random(ROWS) < 0.5, cosine, -cosine)
    tilted = about(rng, a["normal"], cosine)
    b["normal"] = np.where((turn == 1)[:, None], tilted, a["normal"])
    farther = a["depth"] / (1 - like.depth - 0.1 * aside)
    b["depth"] = np.where(turn == 2, farther, a["depth"])
    swap = rng.random(ROWS) < 0.5
    depths = a["depth"].copy(), b["depth"].copy()
    a["depth"] = np.where(swap, depths[1], depths[0])
    b["depth"] = np.where(swap, depths[0], depths[1])
    return _sides(a, b)


LOOKS = (
    # Greys, of which neighbours in the list look alike, and others do not.
    ((0.20, 0.20, 0.20), (0, 0, 1), 2.0),
    ((0.29, 0.29, 0.29), (0, 0, 1), 2.0),
    ((0.38, 0.38, 0.38), (0, 0, 1), 2.0),
    # Of the first one's luminance, nearly.
    ((0.20, 0.20, 0.60), (0, 0, 1), 2.0),
    # Of another red, which is a fifth of the luminance.
    ((0.70, 0.20, 0.20), (0, 0, 1), 2.0),
    # Turned, and seen from behind.
    ((0.20, 0.20, 0.20), (0, 1, 0), 2.0),
    ((0.20, 0.20, 0.20), (0, 0, -1), 2.0),
    # Farther away: by less than a tenth of it, by less of the larger depth, by more.
    ((0.20, 0.20, 0.20), (0, 0, 1), 2.15),
    ((0.20, 0.20, 0.20), (0, 0, 1), 2.21),
    ((0.20, 0.20, 0.20), (0, 0, 1), 2.6),
)
"""Albedo, normal and depth of what pixels of the search see."""


def _turned(like: PixelLikeness) -> tuple[Any, ...]:
    """The first of the walls, turned by a little more than a limit allows."""
    cosine = 0.97 * like.cosine
    return (0.20, 0.20, 0.20), (0, np.sqrt(1 - cosine**2), cosine), 2.0


def _walls(
    rng: Generator, width: int, height: int, tries: int, like: PixelLikeness = FIXED
) -> Tables:
    """Patches of walls, some of them nothing, and tries at both ends of the square."""
    pixels = width * height
    x, y = np.arange(pixels) % width, np.arange(pixels) // width
    patch = x // 2 + (width // 2 + 1) * (y // 3)
    looks = LOOKS if like == FIXED else (*LOOKS, _turned(like))
    often = np.where(np.arange(len(looks)) < 3, 2.0, 1.0)
    look = rng.choice(len(looks), patch.max() + 1, p=often / often.sum())[patch]
    albedo, normal, depth = (
        np.array(column, float)[look] for column in zip(*looks, strict=True)
    )
    # As far apart, measured by what may differ.
    by_albedo, by_depth = like.albedo / 0.1, like.depth / 0.1
    albedo, depth = 0.2 + (albedo - 0.2) * by_albedo, 2.0 + (depth - 2.0) * by_depth
    u = rng.integers(0, 2**24, (pixels, 2, tries)) * 2.0**-24
    u[::7, :, 0], u[3::21, :, 0] = 0.0, 1 - 2.0**-24
    return {
        "albedo": albedo + by_albedo * rng.uniform(0, 0.004, (pixels, 3)),
        "normal": about(rng, normal, 0.9999),
        "depth": depth * (1 + 1e-3 * by_depth * rng.random(pixels)),
        "hit": (rng.random(patch.max() + 1)[patch] > 0.06).astype(np.uint32),
        "u": u,
    }


GIVEN_LIKENESS = (
    PixelLikeness(0.05, 0.7, 0.01),
    PixelLikeness(0.2, 0.95, 0.03),
    PixelLikeness(0.05, 0.7, 0.01, either_side=True),
    PixelLikeness(0.15, 0.8, 0.05, either_side=True),
    PixelLikeness(either_side=True),
)
"""Thresholds of those who have others; first those of the authors' program, nearly."""


def _of_likeness(rng: Generator) -> Iterator[_Asked]:
    for number, like in enumerate(GIVEN_LIKENESS):
        settings: dict[str, Value] = {}
        if (like.albedo, like.cosine, like.depth) != (0.1, 0.9, 0.1):
            settings |= {
                "thresholds": GIVEN,
                "most_albedo": like.albedo,
                "least_cosine": like.cosine,
                "most_depth": like.depth,
            }
        if like.either_side:
            settings["normals"] = EITHER_SIDE
        for word, tables in (
            ("neighbors", _neighbors(rng, like)),
            ("thresholds", _thresholds(rng, like)),
        ):
            yield (
                f"edge-pair-given-{number}-{word}",
                "edge_pair",
                settings,
                tables,
                False,
            )
        width, height = ((27, 22), (18, 33))[number % 2]
        tables = _walls(rng, width, height, 12, like)
        shape: dict[str, Value] = {"width": width, "radius": 2 + number % 2}
        name = f"pair-search-given-{number}"
        yield name, "pair_search", shape | settings, tables, False


def _motions(rng: Generator, width: int, height: int) -> Tables:
    """Pairs of an image that have moved, apart or together, or were nowhere."""
    size = 320
    pixels = width * height
    first = rng.integers(0, pixels, size)
    axis = rng.integers(0, 2, size)
    depth = 10.0 ** rng.uniform(-1, 2, (2, size))
    depth[1, ::5] = depth[0, ::5]
    hit = (rng.random((2, size)) > 0.15).astype(np.uint32)
    depth[hit == 0] = 0.0
    before = rng.integers(0, pixels, (2, size)).astype(np.int32)
    # At the borders of the image as often as within it.
    edge = rng.random((2, size)) < 0.3
    line = rng.integers(0, height, (2, size)) * width
    before[edge] = (line + rng.choice([0, width - 1], (2, size)))[edge]
    before[rng.random((2, size)) < 0.15] = -1
    return {
        "axis": axis.astype(np.uint32),
        "first": first.astype(np.int32),
        "depth_first": depth[0],
        "depth_second": depth[1],
        "hit_first": hit[0],
        "hit_second": hit[1],
        "before_first": before[0],
        "before_second": before[1],
    }


# ------------------------------------------------ images


def _of_colors(rng: Generator) -> Iterator[_Asked]:
    for word, scale in SCALES:
        emission = _lit(rng, (ROWS,), scale)
        emission[::2] = 0.0
        W = 10.0 ** rng.normal(0, 0.5, ROWS)
        W[rng.random(ROWS) < NULL] = 0.0
        tables = {"value": _lit(rng, (ROWS,), scale), "W": W, "emission": emission}
        yield f"primal{word}", "primal", {}, tables, False
    for width, height in ((16, 16), (7, 23), (60, 1), (1, 60)):
        settings: dict[str, Value] = {"width": width}
        size = width * height
        both = rng.normal(size=(2, size, 3))
        tables = {"delta_x": both[0], "delta_y": both[1]}
        name = f"pair-differences-{width}x{height}"
        yield name, "pair_differences", settings, tables, False
        tables = {"color": _lit(rng, (size,), 1.0)}
        yield f"differences-{width}x{height}", "differences", settings, tables, False


def image_rows(
    rng: Generator, width: int, height: int, noise: float
) -> dict[str, NDArray[Any]]:
    """A picture of patches with its differences, both with noise and rare fireflies.

    Parameters
    ----------
    noise : float; standard deviation of what is added to differences
    """
    x, y = np.arange(width * height) % width, np.arange(width * height) // width
    patch = x // 4 + 8 * (y // 3)
    truth = rng.uniform(0.05, 2.0, (patch.max() + 1, 3))[patch]
    truth = truth * (1 + 0.3 * np.sin(0.7 * x + 0.4 * y))[:, None]
    right, below = np.zeros_like(truth), np.zeros_like(truth)
    image = truth.reshape(height, width, 3)
    right.reshape(height, width, 3)[:, :-1] = image[:, 1:] - image[:, :-1]
    below.reshape(height, width, 3)[:-1] = image[1:] - image[:-1]
    P = truth * rng.gamma(2.0, 0.5, truth.shape)
    P[rng.random(len(P)) < 0.02] *= 10.0
    dx, dy = (d * rng.gamma(4.0, 0.25, d.shape) for d in (right, below))
    wild = np.where(rng.random((2, len(P), 1)) < 0.03, 2.0, noise)
    dx += wild[0] * rng.normal(size=P.shape) * (x < width - 1)[:, None]
    dy += wild[1] * rng.normal(size=P.shape) * (y < height - 1)[:, None]
    return {"primal": P, "dx": dx, "dy": dy}


def _of_channels(rng: Generator) -> Iterator[_Asked]:
    for width, height, alpha, ratio in ((14, 11, 0.2, 0.01), (8, 15, 2.0, 0.02)):
        settings: dict[str, Value] = {
            "width": width,
            "alpha": alpha,
            "ratio": ratio,
            "norm": BY_CHANNELS,
        }
        rows = image_rows(rng, width, height, 0.5)
        name = f"poisson-l1-channels-{width}x{height}"
        yield name, "poisson_l1", settings, rows, False


def _of_solvers(rng: Generator) -> Iterator[_Asked]:
    shapes = ((16, 13, 0.2, 1e-3), (9, 17, 0.5, 1e-4), (48, 1, 0.2, 1e-4))
    for width, height, alpha, residual in shapes:
        settings: dict[str, Value] = {
            "width": width,
            "alpha": alpha,
            "residual": residual,
        }
        rows = image_rows(rng, width, height, 0.0)
        yield f"poisson-l2-{width}x{height}", "poisson_l2", settings, rows, False
    sums = ((14, 11, 0.2, 0.01), (8, 15, 2.0, 0.02))
    for width, height, alpha, ratio in sums:
        settings = {"width": width, "alpha": alpha, "ratio": ratio}
        rows = image_rows(rng, width, height, 0.5)
        yield f"poisson-l1-{width}x{height}", "poisson_l1", settings, rows, False
