"""Cases of declared surfaces: kernels of L0, designed rows and a frame of L3.

The rows are those of Lambertian points, whose surfaces get a view and a material.  Half
of the views are such that a microfacet near the normal mirrors the point's own sample,
so that the peaks of lobes are met at every width; of the rest some are below the
horizon, as behind a bump: such a point reflects nothing, and its own reservoir is one
without weight.  A fifth of the points is metal.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s, dot, normalize
from restir_gi.reference.numerics.records import take
from restir_gi.reference.oracle.buffers import given, prefixed
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.contract.surfaces import COATED, GGX, NODES, SURFACE
from restir_gi.reference.oracle.frames import frame_cases, past_rows, rows_then
from restir_gi.reference.oracle.levels.declared import shaded_if_seen
from restir_gi.reference.oracle.levels.draws import about, spread
from restir_gi.reference.oracle.levels.exact import examined_exactly
from restir_gi.reference.oracle.levels.grades import graded
from restir_gi.reference.oracle.levels.kernels import light_points
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.rows import (
    FEW_NEIGHBORS,
    MOST_NEIGHBORS,
    fused_rows,
    in_float32,
    initial_rows,
    moved_rows,
    spatial_rows,
    temporal_rows,
)
from restir_gi.reference.oracle.parts import SEED, whole_contract
from restir_gi.reference.oracle.prepared_frame import PreparedFrame, prepare_frame
from restir_gi.reference.oracle.working_range import SHARP
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.materials.parameters import Kind

ROWS, FRAME_SIZE = 512, 32
"""Of a case of level L0; and pixels of a frame, in each direction."""

SCENE = "glossy-floor"
"""Its floor is a diffuse base under a rough coat; all else is diffuse."""

BELOW, METAL, SMOOTH = 0.06, 0.2, 0.02
"""Shares of views below the horizon and of metals; and of widths, at extremes."""

Buffer = dict[str, NDArray[Any]]

OWN_SAMPLE = {"temporal": "new_position", "moved": "new_position"}
"""Where the sample lies that a point has drawn itself; elsewhere it is ``position``."""


# The same cases for every backend, so that their exact numbers are calculated once.
@lru_cache(maxsize=4)
def surface_kernel_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """Probes of level L0: target and integrand of each declared surface.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2037, seed])
    return tuple(
        Probe("L0", graded(case), examined_exactly)
        for surface in SURFACE.more
        for case in _kernels(rng, surface, precision)
    )


@lru_cache(maxsize=4)
def surface_row_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """Probes of level L3: designed rows of each declared surface.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2038, seed])
    # Of Equation 10 the reservoirs hold what black points do not reflect, too.
    cases = [
        (scattered(initial_rows(rng, "outgoing")), GGX),
        (scattered(initial_rows(rng, "outgoing")), COATED),
        (scattered(temporal_rows(rng, "outgoing", 20.0)), GGX),
        (scattered(temporal_rows(rng, "outgoing", 20.0)), COATED),
        (scattered(moved_rows(rng, "outgoing", 20.0, "1/Z")), GGX),
        (scattered(moved_rows(rng, "outgoing", 20.0, "1/Z")), COATED),
        (scattered(moved_rows(rng, "outgoing", 7.25, "1/M")), GGX),
        (moved_rows(rng, "outgoing", 8.0, "1/Z"), GGX),
        (scattered(spatial_rows(rng, "outgoing", 40.0, "1/Z", FEW_NEIGHBORS)), GGX),
        (scattered(spatial_rows(rng, "outgoing", 40.0, "1/Z", FEW_NEIGHBORS)), COATED),
        (scattered(spatial_rows(rng, "outgoing", 60.0, "1/Z", MOST_NEIGHBORS)), GGX),
        (spatial_rows(rng, "outgoing", 100.0, "1/M", FEW_NEIGHBORS), COATED),
        (scattered(fused_rows(rng, "outgoing", 40.0, "1/Z", FEW_NEIGHBORS)), GGX),
        (scattered(fused_rows(rng, "outgoing", 40.0, "1/Z", FEW_NEIGHBORS)), COATED),
    ]
    return tuple(
        replayed("L3", in_float32(with_materials(rng, case, surface), precision))
        for case, surface in cases
    )


@lru_cache(maxsize=4)
def surface_scene_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """Probes of level L3 in a frame of a scene with a coated floor.

    Parameters
    ----------
    seed : int; of the random numbers of the frame, and of those before it
    """
    kinds = (Kind.LAMBERTIAN, Kind.ROUGH_COATED)
    at = prepare_frame(find_scene(SCENE), FRAME_SIZE, seed, kinds)
    here = _coats(at, None)
    past = {"moved": _coats(at, past_rows(at)), "fused": _coats(at, rows_then(at))}
    return tuple(
        replayed("L3", _declared(case, COATED, given(more, precision)))
        for case in frame_cases(at, precision)
        if SURFACE in whole_contract()[case.pass_name].settings
        for more in [here | prefixed("past", past.get(case.pass_name, {}))]
    )


def _declared(case: Case, surface: str, buffers: Buffers) -> Case:
    """A case of a declared surface, which has more buffers."""
    settings = {**case.settings, SURFACE.name: surface}
    inputs = {**case.inputs, **buffers}
    return replace(
        case, name=f"{case.name}-{surface}", settings=settings, inputs=inputs
    )


# ------------------------------------------------------------------- rows


def scattered(case: Case) -> Case:
    """The same rows with the target of Equation 9."""
    name = case.name.replace("outgoing", "scattered")
    return replace(case, name=name, settings={**case.settings, "target": "scattered"})


def _kernels(rng: Generator, surface: str, precision: Precision) -> Iterator[Case]:
    W = {"W": spread(rng, -3, 3, ROWS) * (rng.random(ROWS) < 0.9)}
    settings: tuple[tuple[str, dict[str, Value], Buffer], ...] = (
        ("target", {"target": "scattered"}, {}),
        ("target", {"target": "outgoing"}, {}),
        ("shade", {}, W),
    )
    for pass_name, words, more in settings:
        points = _mostly_lit(rng, light_points(rng, ROWS))
        name = "-".join(("kernel", pass_name, *map(str, words.values())))
        case = Case(name, pass_name, words, points | more)
        found = with_materials(rng, case, surface, smooth=SMOOTH)
        found = replace(found, inputs=given(found.inputs, precision))
        yield found
        if pass_name == "shade":
            yield shaded_if_seen(found, rng)


def _mostly_lit(rng: Generator, points: Buffer) -> Buffer:
    """Points that see samples of any side, but for most, which see their front."""
    toward = points["position"] - points["visible_position"]
    turned = {}
    for name, side in (("visible_normal", 1.0), ("normal", -1.0)):
        away = side * dot(points[name], toward) < 0
        turn = away & (rng.random(len(toward)) < 0.8)
        turned[name] = np.where(turn[:, None], -points[name], points[name])
    return points | turned


def with_materials(
    rng: Generator, case: Case, surface: str, smooth: float = 0.0
) -> Case:
    """A case whose visible points have a declared surface."""
    inputs = dict(case.inputs)
    own = OWN_SAMPLE.get(case.pass_name, "position")
    inputs |= _materials(rng, inputs, surface, "", own, smooth)
    if case.pass_name in ("moved", "fused"):
        inputs |= _materials(rng, inputs, surface, "past_", "past_position", smooth)
    # Nobody has kept what is not reflected.
    if case.settings.get("target") == "scattered":
        for reservoir, prefix in KEPT_AT.get(case.pass_name, {}).items():
            inputs[reservoir] = np.where(
                _is_below(inputs, prefix), 0.0, inputs[reservoir]
            )
    return _declared(replace(case, inputs=inputs), surface, {})


KEPT_AT: Mapping[str, Mapping[str, str]] = {
    "temporal": {"past_W": ""},
    "moved": {"past_W": "past_"},
    "spatial": {"W": "", "past_W": ""},
    "fused": {"W": "", "past_W": "past_"},
}
"""Weights of reservoirs that a pass is given, and the points where they were kept."""


def _is_below(inputs: Buffers, prefix: str) -> Masks:
    """Whether the view is below the horizon, (N,) bool."""
    below: Masks = dot(inputs[f"{prefix}view"], inputs[f"{prefix}visible_normal"]) <= 0
    return below


def _materials(
    rng: Generator,
    inputs: Buffer,
    surface: str,
    prefix: str,
    sample: str,
    smooth: float,
) -> Buffer:
    """Buffers of materials; metals have no albedo."""
    normal, rows = inputs[f"{prefix}visible_normal"], len(inputs[sample])
    alpha = spread(rng, np.log10(SHARP), 0.0, rows)
    alpha[rng.random(rows) < 0.05] = 1.0
    alpha = np.where(rng.random(rows) < smooth, spread(rng, -3.0, -1.8, rows), alpha)
    toward = inputs[sample] - inputs[f"{prefix}visible_position"]
    found = {"view": _views(rng, normal, toward, alpha), "alpha": alpha}
    if surface == COATED:
        return _prefixed_by(prefix, found | _drawn_coats(rng, rows))
    metal = rng.random(rows) < METAL
    plain = rng.uniform(0.02, 0.08, (rows, 1)) * (rng.random((rows, 1)) < 0.95)
    f0 = np.where(metal[:, None], rng.uniform(0.3, 1.0, (rows, 3)), plain)
    albedo = np.where(metal[:, None], 0.0, inputs[f"{prefix}albedo"])
    return _prefixed_by(prefix, found | {"f0": f0, "albedo": albedo})


def _prefixed_by(prefix: str, buffers: Buffer) -> Buffer:
    """The same buffers under names that begin with a prefix, or as they are."""
    return {prefix + name: array for name, array in buffers.items()}


def _views(rng: Generator, normal: Vec3s, toward: Vec3s, alpha: Scalars) -> Vec3s:
    """Unit vectors to the eye, (N, 3)."""
    rows = len(normal)
    u = rng.random(rows)
    slope = np.minimum(alpha * np.sqrt(u / (1 - u)), 30.0)
    facet, omega = about(rng, normal, 1 / np.sqrt(1 + slope * slope)), normalize(toward)
    mirrored = 2 * dot(omega, facet)[:, None] * facet - omega
    peaks = (dot(mirrored, normal) > 0.02) & (rng.random(rows) < 0.5)
    side = np.where(rng.random(rows) < BELOW, -1.0, 1.0)
    other = about(rng, normal, side * rng.uniform(0.02, 1.0, rows))
    return np.where(peaks[:, None], normalize(mirrored), other)


def _drawn_coats(rng: Generator, rows: int) -> Buffer:
    """Coats whose transmittance rises as that of real ones does, unevenly."""
    ior = 1.0 + spread(rng, -1.3, 0.2, rows)
    cosine = np.linspace(0.0, 1.0, NODES)
    most = 1 - ((ior - 1) / (ior + 1)) ** 2
    rises = 1 - (1 - cosine) ** rng.uniform(2.0, 8.0, (rows, 1))
    uneven = rng.uniform(0.97, 1.0, (rows, NODES))
    return {
        "ior": ior,
        "internal_reflectance": rng.uniform(0.0, 0.8, rows),
        "transmittance": most[:, None] * (0.02 + 0.98 * rises) * uneven,
        "nonlinear": rng.integers(0, 2, rows).astype(np.uint32),
    }


# ------------------------------------------------------------------- a frame


def _coats(at: PreparedFrame, rows: NDArray[Any] | None) -> Buffer:
    """Materials of a frame's points: a diffuse one is a base under no coat at all."""
    surface = at.last.visible.surface
    if rows is not None:
        surface = take(surface, rows)
    table, m = at.world.materials, np.maximum(surface.material, 0)
    coat = table.kind[m] == Kind.ROUGH_COATED

    def of(values: NDArray[Any], without: float) -> NDArray[Any]:
        mask = coat.reshape(coat.shape + (1,) * (values.ndim - 1))
        return np.where(mask, values[m], without)

    return {
        "view": surface.wo,
        "alpha": of(table.alpha, 1.0),
        "ior": of(table.ior, 1.0),
        "internal_reflectance": of(table.keep, 0.0),
        "transmittance": of(table.transmittance, 1.0),
        "nonlinear": (coat & table.nonlinear[m]).astype(np.uint32),
    }
