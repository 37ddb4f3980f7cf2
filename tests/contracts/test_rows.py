"""Rows permuted, split or alone give the same rows, to the last bit.

Bands and threads rest on this, so every kernel is listed here; a public function of the
modules below that is not is a failure.  255 rows are enough for all of NumPy's vector
loops and their remainders.
"""

import ast
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from restir_gi import reference
from restir_gi.reference.numerics import arrays, frames, sampling, tables
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import (
    KeyedUniforms,
    Stream,
    TabledUniforms,
    pcg4d,
    to_unit_interval,
)
from restir_gi.reference.options import checkerboard, history_search, jacobian, roulette
from restir_gi.reference.passes import gbuffer, initial, neighbors
from restir_gi.reference.resampling import (
    jacobian_limits,
    pairwise,
    reservoir,
    shift,
    source,
    suffix,
    target,
)
from restir_gi.reference.resampling.packing import (
    components,
    log_luv,
    octahedral,
    paper,
    restir_pt,
    rounding,
    rtxdi,
    rtxdi_path,
)
from restir_gi.reference.scene.materials import (
    bsdf_sampling,
    coat,
    coated,
    conductor,
    dielectric,
    facets,
    fresnel,
    lambertian,
    microfacet,
    parameters,
    rough_dielectric,
    table,
)
from restir_gi.reference.scene.materials.parameters import Kind
from restir_gi.reference.scene.surface import (
    SurfacePoints,
    VisiblePoints,
    direction_and_distance,
)
from restir_gi.reference.settings import Settings
from restir_gi.reference.strategies import EXAMPLES
from restir_gi.reference.transport import not_reused

WIDTH, HEIGHT = 15, 17
N = WIDTH * HEIGHT

# ---------------------------------------------------------------- one batch of input


def unit(a):
    return a / np.sqrt(np.sum(a * a, axis=-1, keepdims=True))


rng = np.random.default_rng(20210624)
U = tuple(np.floor(rng.random((4, N)) * 2**24) * 2.0**-24)
V = tuple(np.floor(rng.random((4, N)) * 2**24) * 2.0**-24)
A, B, C = rng.normal(size=(3, N, 3))
OMEGA, LOCAL = unit(A), unit(np.abs(B))
WORD = rng.integers(0, 2**32, (4, N), dtype=np.uint32)
ALPHA, COS = rng.uniform(0.05, 1, N), rng.uniform(0, 1, N)
FACETS = facets.Facets(ALPHA, ALPHA < 0.5)
COLOR = rng.random((N, 3))


@dataclass(frozen=True, slots=True)
class Input:
    """A point on each kind of material, and directions, at the same rows."""

    points: SurfacePoints
    wi: Any


def points_on(*kinds):
    """Rows on all examples of some kinds of material, with their table."""
    examples = [m for kind in kinds or Kind for m in EXAMPLES[kind]]
    rows = parameters.tabulate(examples)
    normal = unit(B)
    wo = unit(normal + 0.9 * unit(C))
    smooth = unit(normal + 0.1 * wo)
    material = rng.integers(0, len(examples), N).astype(np.int32)
    front = rng.random(N) < 0.7
    hit = np.where(rng.random(N) < 0.1, -1, np.arange(N)).astype(np.int32)
    color = np.take(rows.color, material, axis=0)
    return rows, SurfacePoints(A, normal, smooth, wo, color, material, hit, front)


TABLE, POINTS = points_on()
WI = unit(POINTS.normal + 0.9 * OMEGA)
SAMPLES = reservoir.Samples(B, -OMEGA, COLOR)
LIVE = rng.random(N) < 0.8
CANDIDATES = reservoir.Candidates(SAMPLES, COS * LIVE, ALPHA * LIVE, np.ceil(9 * COS))
OTHERS = reservoir.Candidates(SAMPLES, ALPHA, COS, np.ceil(5 * ALPHA))
CLOSED = reservoir.Reservoirs(SAMPLES, ALPHA * LIVE, np.ceil(40 * COS))
CODES = paper.pack(A, OMEGA, CLOSED, WORD[1])
AGE_AND_MISC = WORD[2] % 300, WORD[3].astype(np.uint16)
MASK = rng.random(N) < 0.5
WORDS3 = rng.integers(0, 2**16, (N, 3), dtype=np.uint16)
PATHS = rtxdi_path.PathRecord(*WORD[:1], MASK, *WORD, *U[:2], A, ~MASK, *WORD[:2])
VISIBLE = VisiblePoints(POINTS, np.where(POINTS.hit, 1 + 0.1 * COS, 0.0))
COAT = np.array(coat.transmittance_table(0.3, 1.5))
CUMULATIVE = tables.cumulate(np.array([0.2, 0.0, 0.5, 0.3]))
GUIDE = tables.guide_of(CUMULATIVE)


def on(*kinds):
    """A kernel of materials with points of its own kinds alone."""
    rows, points = points_on(*kinds)
    return rows, (Input(points, unit(points.normal + 0.9 * OMEGA)), U)


def of_material(function, *kinds):
    rows, arguments = on(*kinds)
    return (lambda at, u: function(rows, at.points, at.wi)), arguments


def of_view(function, *kinds):
    rows, arguments = on(*kinds)
    return (lambda at, u: function(rows, at.points)), arguments


def of_draw(function, *kinds):
    rows, arguments = on(*kinds)
    return (lambda at, u: function(rows, at.points, u)), arguments


def keyed(pixel):
    return KeyedUniforms(pixel, 7, 3, Stream.SPATIAL).draw(5)


def keyed_and_cut(pixel):
    uniforms = KeyedUniforms(pixel, 7, 3, Stream.SPATIAL)
    return uniforms.rows(np.arange(len(pixel))).draw(5)


def tabled(u, v):
    return TabledUniforms(np.array([u, v])).draw(1)


def search(rows, u, v):
    settings = Settings(radius=0.3)
    return neighbors.find_neighbors(rows, VISIBLE, WIDTH, settings, [u, v, u])


LIMITED = Settings(jacobian_limit=2.0)
METAL = (Kind.ROUGH_CONDUCTOR, Kind.SMOOTH_CONDUCTOR)
ROUGH_METAL, GLASS = (Kind.ROUGH_CONDUCTOR,), (Kind.DIELECTRIC,)
ROUGH_GLASS = (Kind.ROUGH_DIELECTRIC,)
COATS = (Kind.ROUGH_COATED, Kind.SMOOTH_COATED)
ROUGH_COAT, SMOOTH_COAT = (Kind.ROUGH_COATED,), (Kind.SMOOTH_COATED,)
METALS, ON_METALS = points_on(*METAL)

KERNELS = {
    arrays.cross: (arrays.cross, (A, B)),
    arrays.divide_or_zero: (arrays.divide_or_zero, (COS, ALPHA * LIVE)),
    arrays.dot: (arrays.dot, (A, B)),
    arrays.length: (arrays.length, (A,)),
    frames.normal_frames: (frames.normal_frames, (OMEGA,)),
    arrays.normalize: (arrays.normalize, (A,)),
    arrays.plus: (arrays.plus, (COS, ALPHA)),
    arrays.triangle_normal: (arrays.triangle_normal, (A, B)),
    arrays.saturate: (arrays.saturate, (A[:, 0],)),
    arrays.sqrt: (arrays.sqrt, (COS,)),
    frames.to_world: (frames.to_world, (A, OMEGA)),
    arrays.vectors: (arrays.vectors, (COS, ALPHA, U[0])),
    frames.turn: (lambda a: frames.turn(a, C[:3]), (A,)),
    direction_and_distance: (direction_and_distance, (A, B)),
    pcg4d: (pcg4d, tuple(WORD)),
    to_unit_interval: (to_unit_interval, (WORD[0],)),
    KeyedUniforms.draw: (keyed, (WORD[0],)),
    KeyedUniforms.rows: (keyed_and_cut, (WORD[0],)),
    TabledUniforms.draw: (tabled, (U, V)),
    # Sampling.
    sampling.left_of: (sampling.left_of, (U[0], U[1])),
    sampling.invert_cosine_hemisphere: (sampling.invert_cosine_hemisphere, (LOCAL,)),
    sampling.invert_triangle: (sampling.invert_triangle, (COS / 2, ALPHA / 2)),
    sampling.invert_uniform_hemisphere: (sampling.invert_uniform_hemisphere, (LOCAL,)),
    sampling.invert_uniform_sphere: (sampling.invert_uniform_sphere, (OMEGA,)),
    sampling.pdf_cosine_hemisphere: (sampling.pdf_cosine_hemisphere, (A[:, 0],)),
    sampling.pdf_uniform_hemisphere: (sampling.pdf_uniform_hemisphere, (A[:, 0],)),
    sampling.sample_cosine_hemisphere: (sampling.sample_cosine_hemisphere, U[:2]),
    sampling.sample_triangle: (sampling.sample_triangle, U[:2]),
    sampling.sample_uniform_hemisphere: (sampling.sample_uniform_hemisphere, U[:2]),
    sampling.sample_uniform_sphere: (sampling.sample_uniform_sphere, U[:2]),
    tables.sample_table: (lambda u: tables.sample_table(CUMULATIVE, u), (U[0],)),
    tables.index_in_table: (
        lambda u: tables.index_in_table(CUMULATIVE, GUIDE, u),
        (U[0],),
    ),
    # Resampling.
    reservoir.balance_heuristic: (
        lambda a, b, c: reservoir.balance_heuristic([a, b], [b, c], c * LIVE[0]),
        (COS, ALPHA, U[0]),
    ),
    reservoir.one_over_m: (lambda a, b: reservoir.one_over_m([a, b]), (COS, ALPHA)),
    reservoir.one_over_z: (
        lambda a, b, h: reservoir.one_over_z([a, b], [h, ~h]),
        (COS, ALPHA, MASK),
    ),
    reservoir.cap_confidence: (lambda r: reservoir.cap_confidence(r, 20.0), (CLOSED,)),
    reservoir.choose_second: (reservoir.choose_second, (COS, ALPHA, U[0])),
    reservoir.finalize: (lambda c: reservoir.finalize(c, c.M), (CANDIDATES,)),
    reservoir.initial_candidates: (
        reservoir.initial_candidates,
        (SAMPLES, COS, ALPHA * LIVE),
    ),
    reservoir.merge: (reservoir.merge, (CANDIDATES, OTHERS, U[0])),
    reservoir.reused_candidates: (reservoir.reused_candidates, (CLOSED, COS, ALPHA)),
    shift.reconnection_jacobian: (shift.reconnection_jacobian, (A, B, C, OMEGA)),
    jacobian_limits.clamp_jacobian: (
        lambda J: jacobian_limits.clamp_jacobian(J, 2.0),
        (4 * COS * LIVE,),
    ),
    jacobian_limits.within_limit: (
        lambda J: jacobian_limits.within_limit(J, 2.0),
        (4 * COS * LIVE,),
    ),
    pairwise.pairwise_canonical: (
        lambda M, p, q, u: pairwise.pairwise_canonical([M, u], [p, q], M, q, True),
        (CLOSED.M, COS * LIVE, ALPHA, U[0]),
    ),
    pairwise.pairwise_neighbor: (
        lambda M, p, q, u: pairwise.pairwise_neighbor(M, p, u, q, M + u, False),
        (CLOSED.M, COS * LIVE, ALPHA, U[0]),
    ),
    suffix.suffix_of: (
        lambda number, p, kept: suffix.suffix_of(number, p, kept),
        (np.arange(N), POINTS, MASK),
    ),
    suffix.age: (
        lambda number, points: suffix.age(suffix.Suffix(number, points), 99, 7),
        (np.arange(N), POINTS),
    ),
    target.luminance: (target.luminance, (COLOR,)),
    target.target_if_drawn: (
        lambda p, y: target.target_if_drawn("bsdf", "scattered", TABLE, p, y),
        (POINTS, SAMPLES),
    ),
    target.supports: (
        lambda at, y: target.supports("bsdf", "scattered", TABLE, POINTS, at, y),
        (np.arange(N), SAMPLES),
    ),
    target.reflected: (
        lambda p, y: target.reflected(TABLE, p, y),
        (POINTS, SAMPLES),
    ),
    target.target: (
        lambda p, y: (
            target.target("scattered", TABLE, p, y),
            target.target("outgoing", TABLE, p, y),
        ),
        (POINTS, SAMPLES),
    ),
    # Packing.
    components.decode_components: (components.decode_components, (WORDS3,)),
    components.encode_components: (components.encode_components, (OMEGA,)),
    log_luv.decode_log_luv: (log_luv.decode_log_luv, (WORD[0],)),
    log_luv.encode_log_luv: (log_luv.encode_log_luv, (COLOR,)),
    octahedral.decode_normal: (octahedral.decode_normal, (CODES["n_v"],)),
    octahedral.encode_normal: (octahedral.encode_normal, (OMEGA,)),
    paper.pack: (paper.pack, (A, OMEGA, CLOSED, WORD[1])),
    paper.unpack: (paper.unpack, (CODES,)),
    restir_pt.pack: (restir_pt.pack, (A, OMEGA, CLOSED, WORD[1])),
    restir_pt.unpack: (restir_pt.unpack, (CODES.view(restir_pt.RESERVOIR),)),
    rounding.nearest_count: (lambda x: rounding.nearest_count(x, 5), (9 * COS,)),
    rounding.nearest_float: (lambda x: rounding.nearest_float(x, np.float16), (A,)),
    rounding.widened: (rounding.widened, (CODES["L_o"],)),
    rtxdi.pack: (rtxdi.pack, (CLOSED, *AGE_AND_MISC)),
    rtxdi.unpack: (rtxdi.unpack, (rtxdi.pack(CLOSED, *AGE_AND_MISC),)),
    rtxdi_path.pack: (rtxdi_path.pack, (CLOSED, PATHS)),
    rtxdi_path.unpack: (rtxdi_path.unpack, (rtxdi_path.pack(CLOSED, PATHS),)),
    # Materials.
    coat.base_scattering: (coat.base_scattering, (COLOR, COS, MASK)),
    coat.specular_lobe: (coat.specular_lobe, (COS, U[0], U[1], FACETS)),
    coat.transmittance: (lambda c: coat.transmittance(c, COAT), (COS,)),
    coated.base_reflection: of_material(coated.base_reflection, *COATS),
    coated.coat_probability: of_view(coated.coat_probability, *COATS),
    coated.pdf: of_material(coated.pdf, *ROUGH_COAT),
    coated.reflect_in_coat: of_view(coated.reflect_in_coat, *SMOOTH_COAT),
    coated.sample: of_draw(coated.sample, *ROUGH_COAT),
    coated.sample_smooth: of_draw(coated.sample_smooth, *SMOOTH_COAT),
    coated.scattering: of_material(coated.scattering, *ROUGH_COAT),
    conductor.pdf_reflected: of_material(conductor.pdf_reflected, *ROUGH_METAL),
    conductor.reflectance: (
        lambda p, c: conductor.reflectance(METALS, p, c),
        (ON_METALS, COS),
    ),
    conductor.sample_reflected: of_draw(conductor.sample_reflected, *ROUGH_METAL),
    conductor.scattering: of_material(conductor.scattering, *ROUGH_METAL),
    dielectric.sample: of_draw(dielectric.sample, *GLASS),
    fresnel.fresnel_conductor: (fresnel.fresnel_conductor, (COS, COLOR, 3 * COLOR)),
    fresnel.fresnel_dielectric: (fresnel.fresnel_dielectric, (COS, 0.5 + ALPHA)),
    fresnel.fresnel_schlick: (fresnel.fresnel_schlick, (COS, COLOR)),
    lambertian.pdf: of_material(lambertian.pdf, Kind.LAMBERTIAN),
    lambertian.sample: (lambertian.sample, (POINTS, U)),
    lambertian.scattering: of_material(lambertian.scattering, Kind.LAMBERTIAN),
    rough_dielectric.pdf: of_material(rough_dielectric.pdf, *ROUGH_GLASS),
    rough_dielectric.sample: of_draw(rough_dielectric.sample, *ROUGH_GLASS),
    rough_dielectric.scattering: of_material(rough_dielectric.scattering, *ROUGH_GLASS),
    dielectric.relative_index: of_view(dielectric.relative_index, *GLASS),
    conductor.sample_normal: of_draw(conductor.sample_normal, *ROUGH_METAL),
    table.is_shared: of_view(table.is_shared),
    microfacet.beckmann_density: (microfacet.beckmann_density, (COS, ALPHA)),
    microfacet.beckmann_g1: (microfacet.beckmann_g1, (COS, ALPHA)),
    microfacet.facing_share: (microfacet.facing_share, (COS, ALPHA, U[0])),
    microfacet.sample_facing_normal: (
        microfacet.sample_facing_normal,
        (LOCAL, ALPHA, *U[:3]),
    ),
    microfacet.ggx_density: (microfacet.ggx_density, (COS, ALPHA)),
    microfacet.reflect: (microfacet.reflect, (OMEGA, LOCAL)),
    microfacet.sample_visible_normal: (
        microfacet.sample_visible_normal,
        (LOCAL, ALPHA, *U[:2]),
    ),
    microfacet.smith_g1: (microfacet.smith_g1, (COS, ALPHA)),
    parameters.lit_cosine: of_material(parameters.lit_cosine),
    table.can_scatter: of_view(table.can_scatter),
    table.pdf: of_material(table.pdf),
    bsdf_sampling.sample: of_draw(bsdf_sampling.sample),
    bsdf_sampling.sample_apart: of_draw(bsdf_sampling.sample_apart),
    table.scattering: of_material(table.scattering),
    # Passes, as far as they trace no ray.
    gbuffer.similar: (
        lambda n, d, m, e: gbuffer.similar(n, d, m, e, 25.0, 0.05),
        (OMEGA, 1 + 0.1 * COS, unit(OMEGA + 0.3 * LOCAL), 1 + 0.1 * ALPHA),
    ),
    not_reused.is_lambertian: of_view(not_reused.is_lambertian),
    source.sample_source: (
        lambda p, u: tuple(
            source.sample_source(kind, TABLE, p, u)
            for kind in ("uniform", "cosine", "bsdf")
        ),
        (POINTS, U),
    ),
    source.source_pdf: (
        lambda p, w: tuple(
            source.source_pdf(kind, TABLE, p, w)
            for kind in ("uniform", "cosine", "bsdf")
        ),
        (POINTS, WI),
    ),
    neighbors.find_neighbors: (search, (np.arange(N), U, V)),
    checkerboard.draws_new_sample: (
        lambda rows, there: checkerboard.draws_new_sample(rows, WIDTH, 3, there),
        (np.arange(N), MASK),
    ),
    roulette.tail_weight: (
        lambda rows, frame: roulette.tail_weight(rows, WIDTH, 0.5, frame, 3),
        (np.arange(N), np.arange(N) % 5),
    ),
    jacobian.refusal_of: (
        lambda x, z, y: jacobian.refusal_of(LIMITED)(x, z, y),
        (A, C, SAMPLES),
    ),
    jacobian.shift_of: (
        lambda x, z, y: jacobian.shift_of(LIMITED)(x, z, y),
        (A, C, SAMPLES),
    ),
    history_search.nearby: (
        lambda x, y, u: history_search.nearby(x, y, u, 4.0),
        (COS, ALPHA, U),
    ),
    history_search.permuted: (
        lambda rows: history_search.permuted(rows, WIDTH, N // WIDTH, 3),
        (np.arange(N),),
    ),
}

ELSEWHERE = {
    "arrays.zero_vectors": "of a number of rows",
    "tables.cumulate": "a table, not rows",
    "tables.guide_of": "a table, not rows",
    "coat.directional_albedo": "made once for a material",
    "coat.transmittance_table": "made once for a material",
    "coat.internal_reflectance": "made once for a material",
    "paper.buffer_bytes": "a number",
    "parameters.kind_of": "of one material",
    "parameters.tabulate": "of a list of materials",
    "rtxdi.buffer_index": "of a whole frame",
    "table.by_kind": "splits rows, in order",
    "gbuffer.visible_points": "traces rays: tests of the frame loop",
    "initial.initial_samples": "traces rays: tests of the frame loop",
    "not_reused.reuses_all": "of a scene",
    "not_reused.split_light": "traces rays: tests of the frame loop",
    "history_search.find_history": "of a whole frame",
    "jacobian.with_jacobian": "of settings",
    "neighbors.in_disk": "by find_neighbors",
    "neighbors.neighbors_of": "of a whole frame",
    "neighbors.open_border": "by find_neighbors",
    "roulette.tail_weights": "of a frame",
}
"""Functions of the modules that are not kernels, with the reason."""

MODULES = [
    arrays,
    frames,
    sampling,
    tables,
    gbuffer,
    initial,
    neighbors,
    reservoir,
    shift,
    target,
]
MODULES += [checkerboard, history_search, jacobian, jacobian_limits, pairwise]
MODULES += [not_reused, roulette, source, suffix]
MODULES += [coat, coated, conductor, dielectric, fresnel, lambertian, microfacet]
MODULES += [rough_dielectric]
MODULES += [bsdf_sampling, parameters, table]
MODULES += [components, log_luv, octahedral, paper, restir_pt, rounding, rtxdi]
MODULES += [rtxdi_path]


def public_functions(module):
    """Functions that a module defines, by module and name."""
    tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
    names = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    short = module.__name__.rpartition(".")[2]
    return {f"{short}.{name}" for name in names if not name.startswith("_")}


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__)
def test_every_kernel_is_listed(module):
    assert module.__name__.startswith(reference.__name__)
    listed = {f"{f.__module__.rpartition('.')[2]}.{f.__name__}" for f in KERNELS}
    assert public_functions(module) <= listed | set(ELSEWHERE)


# ---------------------------------------------------------------- the contract


def columns(result):
    """All arrays of a result, in order."""
    if result is None:
        return []
    if isinstance(result, np.ndarray):
        return [result]
    if is_dataclass(result):
        result = [getattr(result, field.name) for field in fields(result)]
    return [column for part in result for column in columns(part)]


def cut(argument, rows):
    """Some rows of an argument: an array, a record, or a tuple of them."""
    if isinstance(argument, tuple):
        return tuple(cut(part, rows) for part in argument)
    return take(argument, rows)


def apply(kernel, arguments, rows):
    """Columns of the result for some rows of the input."""
    result = columns(kernel(*(cut(argument, rows) for argument in arguments)))
    assert all(len(column) == len(rows) for column in result)
    return result


def size_of(argument):
    return len(columns(argument)[0])


def faults(kernel, arguments):
    """Ways of cutting and shuffling that change a bit."""
    size = size_of(arguments)
    whole = apply(kernel, arguments, np.arange(size))
    order = np.random.default_rng(1).permutation(size)
    # Singles and pairs, remainders of vector loops, and some of everything.
    at = [1, 2, 4, 7, 12, 20, 37, 70, 101, 165, 200]
    cuts = {
        "permuted": [order],
        "split": np.split(np.arange(size), at),
        "split and permuted": np.split(order, at),
    }
    found = []
    for name, pieces in cuts.items():
        for piece in pieces:
            for a, b in zip(apply(kernel, arguments, piece), whole, strict=True):
                expected = b.take(piece, axis=0)
                if a.dtype != b.dtype or a.tobytes() != expected.tobytes():
                    found.append(f"{name}: {len(piece)} rows")
    return found


def name_of(kernel):
    return f"{kernel.__module__.rpartition('.')[2]}.{kernel.__qualname__}"


@pytest.mark.parametrize("name", KERNELS, ids=name_of)
def test_rows_do_not_know_each_other(name):
    assert faults(*KERNELS[name]) == []


@pytest.mark.parametrize("name", KERNELS, ids=name_of)
def test_no_rows_are_rows_too(name):
    kernel, arguments = KERNELS[name]
    apply(kernel, arguments, np.arange(0))


@pytest.mark.parametrize("name", KERNELS, ids=name_of)
def test_kernels_leave_their_input_alone(name):
    kernel, arguments = KERNELS[name]
    before = [column.copy() for column in columns(arguments)]
    kernel(*arguments)
    for old, new in zip(before, columns(arguments), strict=True):
        assert_array_equal(old, new)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda a: a - a.mean(axis=0),
        lambda a: a + (len(a) == N),
        lambda a: np.roll(a, 1, axis=0),
        lambda a: a[:1] + 0 * a,
    ],
)
def test_control_a_kernel_that_looks_at_other_rows_is_found(wrong):
    assert faults(wrong, (A,)) != []
