"""Jacobians where materials have several lobes, which can draw the same direction.

Then a path has one point of primary sample space for each choice of lobes, and T is no
mapping of points.  What holds is a statement about densities: paths are told apart by
their points alone, so that the numbers which choose lobes are summed over, and

    J = D_to / D_from,   D = Π Σ_lobes P_lobe |∂(u1, u2) / ∂(place or direction)|,

the first factor at x_(c-1), per area at x_c, the second at x_c, per solid angle.  Each
term comes from finite differences of the sampler's inverse, one lobe at a time.
"""

from functools import cache, partial

import numpy as np
import pytest

from restir_gi.reference.numerics.arrays import normalize
from restir_gi.reference.numerics.frames import normal_frames
from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.materials.bsdf_sampling import HAS_DELTA
from restir_gi.reference.scene.materials.parameters import Kind
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.surface import direction_and_distance
from tests.properties.path_inverses import derivatives, directions, guessed, inverted
from tests.properties.path_numbers import SOLVED, joined
from tests.properties.path_scenes import SIZE, seen_from

COATS = (Kind.ROUGH_COATED, Kind.SMOOTH_COATED)
KINDS = (Kind.LAMBERTIAN, Kind.ROUGH_CONDUCTOR, *COATS)
LOBES = (0.0, 1.0 - 2.0**-24)
"""Lanes 0 that choose the coat, and the base."""


H = 1e-4
"""Half the step, as an angle, and then half of that."""

FEW = 80
"""Paths of the test that is not slow."""

INNER = 0.01
"""First numbers closer to 0 or 1 are left out: there derivatives have no bound."""

INVERSE = 1e-8
"""What Newton's method leaves, over `H`, with a hundredfold for steep lobes."""


def chance_of_coat(w, x):
    """By bisection: up to which lane 0 a point is left as it is with 0."""
    low, high = np.zeros(len(x)), np.ones(len(x))
    u = np.full((len(x), 2), 0.4)
    coat = directions(w, x, u, LOBES[0])
    for _ in range(40):
        middle = 0.5 * (low + high)
        same = np.all(directions(w, x, u, middle) == coat, axis=1)
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return low


def summands(w, x, aim, weighed):
    """P |∂u / ∂a| of the directions aim(a) at a = 0, and where it can be had.

    (2, 2, N): the coat and the base, for steps of H and H / 2.
    """
    here, kind = np.zeros((len(x), 2)), w.materials.kind[x.material]
    coat = chance_of_coat(w, x) * np.isin(kind, COATS)
    found, able = np.zeros((2, 2, len(x))), np.ones(len(x), bool)
    for lobe, share, steps in zip(LOBES, (coat, 1.0 - coat), found, strict=True):
        single = np.isin(kind, HAS_DELTA) & (lobe == LOBES[0])
        rows = np.flatnonzero((share > 0) & ~single)
        some, target = take(x, rows), aim(rows)(here[rows])
        guess = guessed(w, some, target, lobe, 12)
        u, error = inverted(w, some, target, guess, lobe)
        inner = (u[:, 0] > INNER) & (u[:, 0] < 1 - INNER)
        fits = inner & (error < SOLVED)
        able[rows[~fits]] = False
        rows, u = rows[fits], u[fits]
        inverse = partial(numbers, w, take(x, rows), aim(rows), u, lobe)
        for part, h in zip(steps, (H, H / 2), strict=True):
            slope = np.linalg.det(derivatives(inverse, here[rows], h))
            part[rows] = np.abs(slope) * (share[rows] if weighed else 1.0)
    return found, able


def numbers(w, x, towards, u, lobe, a):
    """Those of a lobe, close to u, that lead towards a."""
    return inverted(w, x, towards(a), u, lobe)[0]


def at_places(x, x_s, normal):
    """Directions from points to places in a plane, by how far off over the distance."""
    _, d = direction_and_distance(x.position, x_s)
    tangents = [d[:, None] * t for t in normal_frames(normal)]

    def aim(rows):
        return lambda a: direction_and_distance(
            x.position[rows], x_s[rows] + sum(moved(a, tangents, rows))
        )[0]

    return aim, d


def at_angles(omega):
    """Directions about directions."""
    tangents = normal_frames(omega)
    return lambda rows: lambda a: normalize(omega[rows] + sum(moved(a, tangents, rows)))


def moved(a, tangents, rows):
    return [a[:, i, None] * t[rows] for i, t in enumerate(tangents)]


@cache
def densities(name, most, weighed):
    """Both factors of D for either pixel, the rows that count, and what is stated."""
    found = joined(name, "hybrid", 0, KINDS)
    every = np.arange(0, len(found.jacobian), max(1, len(found.jacobian) // most))
    joints = found.joints.of(every)
    w, paths, able = joints.world, joints.paths, True
    x_s, ends = contact(w.geometry, paths.surface), []
    for x in (joints.x_from, joints.x_to):
        aim, d = at_places(x, x_s, paths.surface.normal)
        first, left = summands(w, x, aim, weighed)
        there, _ = seen_from(w, x, paths.surface, x_s)
        second, onward = summands(w, there, at_angles(paths.wi), weighed)
        able = able & left & (onward | joints.chosen)
        ends.append((first / d**2, second))
    return ends, joints.chosen, np.flatnonzero(able), found.jacobian[every]


def errors(name, lobes=(0, 1), most=FEW, weighed=True):
    """Of the stated Jacobians against the sums over lobes, and what is allowed."""
    ends, chosen, rows, stated = densities(name, most, weighed)
    d_from, d_to = (
        sum(first[k] for k in lobes)
        * np.where(chosen, 1.0, sum(second[k] for k in lobes))
        for first, second in ends
    )
    (coarse, fine), stated = d_to[:, rows] / d_from[:, rows], stated[rows]
    error = np.abs((4 * fine - coarse) / 3 / stated - 1)
    return error, np.abs(fine - coarse) / stated + INVERSE


def test_the_jacobian_is_the_ratio_of_sums_over_lobes():
    error, allowed = errors("rough coat")
    assert len(error) > 60
    assert (error <= allowed).all()
    assert np.median(allowed) < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rough coat", "smooth coat", "glossy-floor"])
def test_so_it_is_for_all_paths_of_a_frame(name):
    error, allowed = errors(name, most=SIZE * SIZE)
    sizes = np.median(error), error.max(), np.median(allowed), allowed.max()
    print(name, len(error), *(f"{size:.2g}" for size in sizes))  # noqa: T201
    assert len(error) > 300
    assert (error <= allowed).all()


def test_control_the_base_alone_is_refuted():
    error, allowed = errors("rough coat", lobes=(1,))
    assert np.mean(error > allowed) > 0.1


@pytest.mark.slow
def test_control_without_the_chances_of_lobes_is_refuted():
    error, allowed = errors("smooth coat", most=SIZE * SIZE, weighed=False)
    assert np.mean(error > allowed) > 0.1
