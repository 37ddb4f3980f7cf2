"""The passes themselves, integrated exactly over injected reservoirs.

Three pixels of a small real scene may hold any of six sample points.  Each joint
outcome is a line of an image of its own, three pixels wide; random numbers are a table,
made so that the neighbours are the other two pixels and each decision falls to a given
side.  Probabilities of the decisions come from the weights as theory has them, so that
a pass with other weights loses its balance.  Then E[W 1{y = x}] must be mu_q(x), the
solid angle of the patch at x, for every x that q sees: to rounding, without statistics.
"""

import itertools
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.numerics.rng import TabledUniforms
from restir_gi.reference.passes import pixels as pixels_module
from restir_gi.reference.passes import temporal as temporal_module
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.passes.initial import InitialSamples
from restir_gi.reference.passes.neighbors import neighbors_of
from restir_gi.reference.passes.pixels import (
    FrameReservoirs,
    History,
    NeighborPixels,
    Pixels,
    sees,
)
from restir_gi.reference.resampling import generalized as engine_module
from restir_gi.reference.resampling import pairwise as production
from restir_gi.reference.resampling import reuse as reuse_module
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.resampling.target import target
from restir_gi.reference.restir_gi import OWN, PassInput, pixels_of, resampled
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.materials.kinds import Conductor, Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import quad
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.world import World, build_world

PIXELS, NOTHING = 3, 6

PLACE = np.array(
    [
        [0.3, 1.5, 0.2],
        [-1.0, 1.2, 0.5],
        [1.2, 1.0, -0.6],
        [2.2, 2.0, 0.8],
        [-1.5, 1.8, -0.9],
        [-0.4, 0.9, -1.1],
        [0.0, 5.0, 0.0],
    ]
)
FACING = np.array(
    [
        [0.0, -1.0, 0.0],
        [0.9, -0.4, 0.0],
        [-0.3, -0.9, 0.2],
        [-0.5, -0.8, -0.1],
        [0.2, -0.9, 0.3],
        [0.0, -0.7, 0.7],
        [0.0, -1.0, 0.0],
    ]
)
NORMAL = FACING / np.linalg.norm(FACING, axis=1, keepdims=True)
LIGHT = np.array([3.0, 1.0, 2.0, 5.0, 0.5, 4.0, 0.0])
COLOR = np.array([[1.0, 0.9, 0.8]])
PATCH = 0.01
"""Area of each cell."""

HIDDEN = [(0, 3), (1, 4), (2, 2), (2, 5)]
"""Pixels and the cells that a small screen hides from them."""

UNLIT = [(0, 1)]
"""Pixel 0 is behind the patch of cell 1."""

TRUST = np.array([1.0, 3.0, 2.0])
PAST = 4.0
"""Confidences: of the temporal reservoirs, and of what the last frame left."""

PAINT, METAL = Lambertian((0.8, 0.5, 0.2)), Conductor((0.9, 0.6, 0.3), 0.6)


@dataclass(frozen=True)
class Stage:
    """The scene, what its three pixels see, and the tables of theory."""

    world: World
    visible: object
    mu: np.ndarray
    holds: np.ndarray
    chance: np.ndarray


def build(material, place=PLACE, normal=NORMAL, hidden=HIDDEN, unlit=UNLIT):
    """A floor, the camera, and screens half-way between pixels and hidden cells."""
    camera = Camera((0.0, 2.0, 6.0), (0.0, 0.0, 0.0), fov=50.0, width=3, height=1)
    floor = quad("floor", (-9, 0, 9), (18, 0, 0), (0, 0, -18), material)
    bare = build_world(Scene(name="floor", camera=camera, meshes=(floor,)))
    centers = np.array([0.5, 1.5, 2.5]), np.full(3, 0.5)
    eyes = visible_points(bare, *centers).surface.position
    screens = []
    for i, x in hidden:
        middle = (eyes[i] + place[x]) / 2
        corner = tuple(middle - [0.03, 0.0, 0.03])
        name = f"screen {i} {x}"
        screens.append(quad(name, corner, (0.06, 0, 0), (0, 0, 0.06), material))
    world = build_world(Scene(name="screens", camera=camera, meshes=(floor, *screens)))
    visible = visible_points(world, *centers)
    v = visible.surface.position[:, None] - place[None, :NOTHING]
    d = np.sqrt(np.sum(v * v, axis=-1))
    mu = PATCH * abs(np.sum(v * normal[:NOTHING], axis=-1)) / d**3
    holds = np.ones((PIXELS, NOTHING), bool)
    for i, x in hidden + unlit:
        holds[i, x] = False
    # Unequal probabilities, and something left for nothing.
    weight = holds * np.array([3, 1, 2, 2, 1, 3])
    chance = weight / (weight.sum(axis=1, keepdims=True) + np.array([[1], [2], [3]]))
    return Stage(world, visible, mu, holds, chance)


@pytest.fixture(scope="module", params=[PAINT, METAL], ids=["paint", "metal"])
def stage(request):
    return build(request.param)


def samples(cells):
    """Sample points by number; number 6 is a null."""
    radiance = LIGHT[cells][:, None] * COLOR
    return Samples(PLACE[cells], NORMAL[cells], radiance)


def cells_of(y):
    """Numbers of sample points."""
    distance = np.abs(y.position[:, None] - PLACE[None]).sum(axis=-1)
    assert (distance.min(axis=1) == 0).all()
    return distance.argmin(axis=1)


def test_the_screens_hide_what_they_should(stage):
    i, x = (
        g.ravel() for g in np.meshgrid(range(PIXELS), range(NOTHING), indexing="ij")
    )
    viewpoints = take(stage.visible.surface, i)
    seen = sees(stage.world, viewpoints, samples(x), np.ones(len(x), bool))
    hidden = {(int(a), int(b)) for a, b in zip(i[~seen], x[~seen], strict=True)}
    assert hidden == set(HIDDEN)
    behind = np.sum((stage.visible.surface.position[i] - PLACE[x]) * NORMAL[x], -1) < 0
    assert {(int(a), int(b)) for a, b in zip(i[behind], x[behind], strict=True)} == set(
        UNLIT
    )


# ---------------------------------------------------------------- spatial pass


def outcomes(stage):
    """Joint outcomes of three temporal reservoirs and one of the past, and decisions.

    Columns: cells of pixels 0, 1, 2; place of the past's cell in the list of its pixel;
    three bits.
    """
    supports = [[*np.flatnonzero(stage.holds[i]), NOTHING] for i in range(PIXELS)]
    longest = max(map(len, supports))
    grid = itertools.product(*supports, range(longest), *[(0, 1)] * 3)
    return np.array(list(grid)), supports


def probability_of(stage, i, cells):
    """Probability that pixel i draws cells; what is left is nothing."""
    table = np.append(stage.chance[i], 1 - stage.chance[i].sum())
    return table[cells]


def weight_of(stage, i, cells):
    """W of a fresh sample: the cell's measure over its probability."""
    table = np.zeros(NOTHING + 1)
    able = stage.holds[i]
    table[:NOTHING][able] = stage.mu[i][able] / stage.chance[i][able]
    return table[cells]


def targets(stage, kind):
    """Target of each cell at each pixel, without visibility."""
    i, x = (
        np.repeat(np.arange(PIXELS), NOTHING + 1),
        np.tile(np.arange(NOTHING + 1), PIXELS),
    )
    receivers = take(stage.visible.surface, i)
    p_hat = target(kind, stage.world.materials, receivers, samples(x))
    return p_hat.reshape(PIXELS, NOTHING + 1)


def side(bit, w_a, w_b):
    """Number on the given side of the threshold w_b / (w_a + w_b), and its probability.

    A billionth beside it: weights that are off by more decide otherwise.
    """
    total = w_a + w_b
    t = np.divide(w_b, total, out=np.zeros_like(total), where=total > 0)
    u = np.where(bit, t * (1 - 1e-9), t + (1 - t) * 1e-9)
    return np.minimum(u, 1 - 2.0**-53), np.where(bit, t, 1 - t)


NEIGHBORS = {0: (1, 2), 1: (0, 2), 2: (1, 0)}
"""In which order each pixel looks at the others."""


def toward(step):
    """Lanes 0 and 1 of a neighbour `step` pixels to the right, within a radius of 3."""
    return (abs(step) / 3) ** 2, 0.0 if step > 0 else 0.5


def in_pairs(stage, i, settings, weights, cells):
    """Weights of past, own and neighbours with m in place of M, from theory."""
    M = np.array([PAST, TRUST[i], *(TRUST[k] for k in NEIGHBORS[i])])
    p_hat = targets(stage, settings.target)
    sources = {0: i, 2: NEIGHBORS[i][0], 3: NEIGHBORS[i][1]}
    S = PAST + TRUST[list(NEIGHBORS[i])].sum()
    total = S + M[1] if settings.mis == "defensive" else S

    def pair(slot, y):
        """S p_k(y) and M_c p_c(y), in the measure of pixel i."""
        k = sources[slot]
        held, measure = np.append(stage.holds[k], False), np.append(stage.mu[k], 1.0)
        p_k = np.where(held[y], p_hat[k][y], 0) * measure[y]
        p_k = p_k / np.append(stage.mu[i], 1.0)[y]
        return S * p_k, M[1] * p_hat[i][y]

    def share(part, other):
        both = part + other
        return np.divide(part, both, out=np.zeros_like(both), where=both > 0)

    found = list(weights)
    for slot in sources:
        m = M[slot] / total * share(*pair(slot, cells[slot]))
        found[slot] = weights[slot] / M[slot] * m
    left = [M[slot] / total * share(*pair(slot, cells[1])[::-1]) for slot in sources]
    m = sum(left) + (M[1] / total if settings.mis == "defensive" else 0.0)
    found[1] = weights[1] / M[1] * m
    return found


def contributions(stage, settings, as_they_stand=True):
    """E[W 1{y = x}] of each pixel after one spatial pass, all lines at once."""
    table, supports = outcomes(stage)
    lines = len(table)
    p_hat = targets(stage, settings.target)
    sees_all = stage.holds | np.isin(
        np.arange(PIXELS * NOTHING).reshape(PIXELS, NOTHING),
        [i * NOTHING + x for i, x in UNLIT],
    )
    visibility = np.column_stack([sees_all, np.zeros(PIXELS, bool)])
    mu = np.column_stack([stage.mu, np.ones(PIXELS)])
    temporal_cells = table[:, :PIXELS]
    W = np.column_stack(
        [weight_of(stage, i, temporal_cells[:, i]) for i in range(PIXELS)]
    )
    chance = np.prod(
        [probability_of(stage, i, temporal_cells[:, i]) for i in range(PIXELS)], axis=0
    )
    uniforms = np.zeros((64, 4, lines, PIXELS))
    probability, past_cells = np.zeros((2, lines, PIXELS))
    past_cells = past_cells.astype(int)
    for i in range(PIXELS):
        support = np.array(supports[i])
        place = np.minimum(table[:, PIXELS], len(support) - 1)
        past = support[place]
        once = table[:, PIXELS] < len(support)
        past_cells[:, i] = past
        p = chance * once * probability_of(stage, i, past)
        # Weights as theory has them: past, own, then the neighbours.
        w = p_hat[i][past] * weight_of(stage, i, past) * PAST
        own = temporal_cells[:, i]
        candidates = [p_hat[i][own] * W[:, i] * TRUST[i]]
        for k in NEIGHBORS[i]:
            y = temporal_cells[:, k]
            reused = p_hat[i][y] * W[:, k] * TRUST[k] * mu[i][y] / mu[k][y]
            if settings.visibility == "all":
                reused = reused * visibility[i][y]
            candidates.append(reused)
        if settings.mis in ("pairwise", "defensive"):
            cells = [past, own, *(temporal_cells[:, k] for k in NEIGHBORS[i])]
            w, *candidates = in_pairs(stage, i, settings, [w, *candidates], cells)
        lanes = [(63, 0), (0, 2), (1, 2)]
        for bit, (dimension, lane), candidate in zip(
            table[:, PIXELS + 1 :].T, lanes, candidates, strict=True
        ):
            u, chance_of_side = side(bit, w, candidate)
            uniforms[dimension, lane, :, i] = u
            p = p * chance_of_side
            w = w + candidate
        probability[:, i] = p
        for s, k in enumerate(NEIGHBORS[i]):
            uniforms[s, :2, :, i] = np.array(toward(k - i))[:, None]
    # Each line of pixels is an image of its own: neighbours lie beside, none above.
    every = np.tile(np.arange(PIXELS), lines)
    r = Reservoirs(samples(temporal_cells.ravel()), W.ravel(), TRUST[every])
    past_W = np.column_stack(
        [weight_of(stage, i, past_cells[:, i]) for i in range(PIXELS)]
    )
    before = Reservoirs(
        samples(past_cells.ravel()), past_W.ravel(), np.full(lines * PIXELS, PAST)
    )
    visible = take(stage.visible, every)
    rows, u = slice(0, lines * PIXELS), TabledUniforms(uniforms.reshape(64, 4, -1))
    q = receivers(stage.world, visible, settings)
    last = FrameReservoirs(stage.world, visible, before)
    past = History(last, last, shifted=not as_they_stand).of(last, q, rows)
    here = FrameReservoirs(stage.world, visible, r)
    around = neighbors_of(q, here, np.arange(lines * PIXELS), u, 2)
    given = PassInput(q, past, r, u.draw(OWN)[0], around)
    kept = resampled(given, settings, settings.spatial_cap)
    assert_allclose(probability.sum(axis=0), 1, rtol=1e-13)
    found = np.zeros((PIXELS, NOTHING))
    cells, weights = cells_of(kept.y).reshape(-1, PIXELS), kept.W.reshape(-1, PIXELS)
    for i, x in np.ndindex(PIXELS, NOTHING):
        found[i, x] = np.sum((probability * weights)[:, i][cells[:, i] == x])
    assert (kept.M[probability.ravel() > 0] == TRUST.sum() + PAST).all()
    return found


def receivers(world, visible, settings):
    """Pixels that resample."""
    frame = SimpleNamespace(world=world, visible=visible, settings=settings)
    return pixels_of(frame, slice(0, len(visible.depth)))


def settings_for(**changes):
    """Two neighbours, however they look, and no cap."""
    loose = {"max_angle": 180.0, "max_depth": 1.0, "spatial_cap": 1e9}
    return Settings(iterations_many=2, iterations_few=2, **loose, **changes)


def truth(stage):
    return np.where(stage.holds, stage.mu, 0.0)


def is_true(stage, settings, as_they_stand=True):
    """Whether all contributions are the measures, to rounding.

    Each W has some 60 roundings, and Jacobians at cosines above 0.05, κ < 20, with 4 κ
    each: 250 eps.  Sums of positive terms do not add to that.
    """
    found = contributions(stage, settings, as_they_stand)
    return np.allclose(found, truth(stage), rtol=500 * np.finfo(float).eps, atol=0)


@pytest.mark.parametrize("kind", ["scattered", "outgoing"])
@pytest.mark.parametrize("mis", ["1/Z", "balance", "pairwise", "defensive"])
@pytest.mark.parametrize("visibility", ["all", "chosen"])
@pytest.mark.parametrize("as_they_stand", [True, False])
def test_the_spatial_pass_is_unbiased(stage, kind, mis, visibility, as_they_stand):
    """The past is shifted too, if asked: to where it was, with a Jacobian of 1."""
    settings = settings_for(target=kind, mis=mis, visibility=visibility)
    assert is_true(stage, settings, as_they_stand)


@pytest.mark.parametrize("mis", ["1/Z", "balance", "pairwise", "defensive"])
@pytest.mark.parametrize("material", [PAINT, METAL], ids=["paint", "metal"])
def test_a_black_donor_counts_where_the_target_does_not_mind_it(material, mis):
    """A black pixel has drawn its sample as all others: Equation 10 lets it be lent."""
    stage = build(material)
    surface = stage.visible.surface
    color = np.where(np.arange(PIXELS)[:, None] == 1, 0.0, surface.color)
    visible = replace(stage.visible, surface=replace(surface, color=color))
    stage = replace(stage, visible=visible)
    assert is_true(stage, settings_for(target="outgoing", mis=mis))


@pytest.mark.parametrize("kind", ["scattered", "outgoing"])
def test_1_over_m_is_dark_by_the_share_that_could_not_have_made_it(stage, kind):
    """mu(x) Σ M_k [k holds x] / Σ M_k, the past counted with its pixel."""
    found = contributions(stage, settings_for(target=kind, mis="1/M"))
    held = stage.holds.T @ TRUST + PAST * stage.holds
    expected = truth(stage) * held / (TRUST.sum() + PAST)
    assert_allclose(found, expected, rtol=500 * np.finfo(float).eps)


def divided(*places, jacobian=pixels_module.reconnection_jacobian):
    """1/J, and 0 where there is no J."""
    J = jacobian(*places)
    return np.divide(1.0, J, out=np.zeros_like(J), where=J != 0)


def swapped(x_from, x_to, *patch, jacobian=pixels_module.reconnection_jacobian):
    return jacobian(x_to, x_from, *patch)


def left_out(x_from, x_to, *patch):
    return np.ones(len(x_to))


def sees_everything(q, y, asked):
    return asked


def blind(q_n, y, asked):
    """Whether q_n could have made y, whatever hides it."""
    return asked & (q_n.rows != NONE) & q_n.supports(y)


def all_confidences(M_k, holds_k):
    return sum(M_k)


PLANTED = [
    (pixels_module, "reconnection_jacobian", divided),
    (pixels_module, "reconnection_jacobian", swapped),
    (pixels_module, "reconnection_jacobian", left_out),
    (Pixels, "sees", sees_everything),
    (NeighborPixels, "could_make", blind),
    (reuse_module, "one_over_z", all_confidences),
]


def of_all_and_the_own(
    M_k, p_k, M_c, p_c, S, *how, weight=production.pairwise_neighbor
):
    """S with the canonical sample's confidence in it."""
    return weight(M_k, p_k, M_c, p_c, S + M_c, *how)


def without_its_own_share(
    M_k, p_k, M_c, p_c, how, weight=production.pairwise_canonical
):
    m, S = weight(M_k, p_k, M_c, p_c, how), sum(M_k)
    return m - M_c / (S + M_c)


def as_if_all_could(M_k, p_k, M_c, p_c, how, weight=production.pairwise_canonical):
    return weight(M_k, [p_c] * len(p_k), M_c, p_c, how)


PLANTED_IN_PAIRS = [
    ("defensive", "pairwise_neighbor", of_all_and_the_own),
    ("pairwise", "pairwise_neighbor", of_all_and_the_own),
    ("defensive", "pairwise_canonical", without_its_own_share),
    ("pairwise", "pairwise_canonical", as_if_all_could),
]


@pytest.mark.parametrize(("mis", "name", "wrong"), PLANTED_IN_PAIRS)
def test_control_planted_mistakes_in_pairs_are_refuted(monkeypatch, mis, name, wrong):
    stage, settings = build(PAINT), settings_for(mis=mis)
    assert is_true(stage, settings)
    monkeypatch.setattr(engine_module, name, wrong)
    assert not is_true(stage, settings)


@pytest.mark.parametrize(("module", "name", "wrong"), PLANTED)
def test_control_planted_mistakes_are_refuted(monkeypatch, module, name, wrong):
    stage, settings = build(PAINT), settings_for()
    assert is_true(stage, settings)
    monkeypatch.setattr(module, name, wrong)
    assert not is_true(stage, settings)


# ---------------------------------------------------------------- temporal pass


def temporal_chain(stage, i, kind, cap, frames=3):
    """E[W 1{y = x}] after each frame: every outcome of the last, drawn on."""
    support = np.array([*np.flatnonzero(stage.holds[i]), NOTHING])
    p_hat = targets(stage, kind)[i]
    cells, W, M, probability = support, None, None, probability_of(stage, i, support)
    history = None
    for _ in range(frames):
        new, bit = cells, np.zeros(len(cells), int)
        if history is not None:
            old, fresh, bit = (
                g.ravel()
                for g in np.meshgrid(range(len(W)), support, (0, 1), indexing="ij")
            )
            history, new = take(history, old), fresh
            w_a = p_hat[cells_of(history.y)] * history.W * history.M
            w_b = p_hat[new] * weight_of(stage, i, new)
            u, chance = side(bit, w_a, w_b)
            probability = probability[old] * probability_of(stage, i, new) * chance
        else:
            u = np.zeros(len(cells))
        count = len(new)
        points = take(stage.visible.surface, np.full(count, i))
        fresh_W = weight_of(stage, i, new)
        pdf = np.divide(1.0, fresh_W, out=np.zeros(count), where=fresh_W > 0)
        uniforms = TabledUniforms(np.broadcast_to(u, (1, 4, count)))
        ones, none = np.ones(count), np.zeros(count)
        drawn = InitialSamples(samples(new), pdf, ones, np.zeros((count, 3)))
        settings = Settings(target=kind, temporal_cap=cap)
        visible = VisiblePoints(points, ones)
        q = receivers(stage.world, visible, settings)
        past = Reservoirs(drawn.y, none, none)
        if history is not None:
            last = FrameReservoirs(stage.world, visible, history)
            past = History(last, last).of(last, q, slice(0, count))
        given = PassInput(q, past, drawn, uniforms.draw(0)[0], [])
        history = resampled(given, settings, cap)
        # Impossible sides of a decision go no further.
        alive = np.flatnonzero(probability > 0)
        history, probability = take(history, alive), probability[alive]
        cells, W, M = cells_of(history.y), history.W, history.M
        found = [np.sum((probability * W)[cells == x]) for x in range(NOTHING)]
        yield np.array(found), M


def is_true_in_each_frame(stage, i, kind, cap):
    """Whether three frames, across the cap, hold; ten roundings a frame in each W."""
    return all(
        np.allclose(found, truth(stage)[i], rtol=100 * np.finfo(float).eps, atol=0)
        and (min(cap, frame + 1) == M).all()
        for frame, (found, M) in enumerate(temporal_chain(stage, i, kind, cap))
    )


@pytest.mark.parametrize("kind", ["scattered", "outgoing"])
@pytest.mark.parametrize("cap", [1.0, 2.0, 30.0])
def test_the_temporal_pass_is_unbiased_in_each_frame(stage, kind, cap):
    for i in range(PIXELS):
        assert is_true_in_each_frame(stage, i, kind, cap)


def nulls_left_out(*drawn, initial=temporal_module.initial_candidates):
    c = initial(*drawn)
    return replace(c, M=(c.w > 0) * 1.0)


def weight_capped(r, cap):
    return replace(r, W=r.W * np.minimum(1.0, cap / np.maximum(r.M, 1.0)))


def of_the_new_alone(M_k, holds_k):
    return M_k[-1]


PLANTED_IN_TIME = [
    (temporal_module, "initial_candidates", nulls_left_out),
    (temporal_module, "cap_confidence", weight_capped),
    (reuse_module, "one_over_z", of_the_new_alone),
]


@pytest.mark.parametrize(("module", "name", "wrong"), PLANTED_IN_TIME)
def test_control_planted_mistakes_are_refuted_in_time(monkeypatch, module, name, wrong):
    stage = build(PAINT)
    assert is_true_in_each_frame(stage, 1, "scattered", 2.0)
    monkeypatch.setattr(module, name, wrong)
    assert not is_true_in_each_frame(stage, 1, "scattered", 2.0)
