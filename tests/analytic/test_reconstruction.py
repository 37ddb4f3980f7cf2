"""Images from pixels and differences: exact solutions, and what may not be given.

Controls: axes swapped, signs turned, borders that wrap: each must show.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import sparse
from scipy.optimize import linprog
from scipy.sparse.linalg import spsolve

from restir_gi.gradient_domain.least_absolute import least_absolute
from restir_gi.gradient_domain.reconstruction import (
    ALPHA,
    Differences,
    differences,
    least_squares,
    spread_back,
)

EPS = 2.0**-52
SIZES = [(1, 1), (1, 7), (9, 1), (2, 2), (13, 8), (64, 48)]


def noise(width, height, channels=3, seed=0):
    return np.random.default_rng(seed).gamma(0.5, size=(width * height, channels))


def given(width, height, channels=3, seed=0):
    """Pixels, and differences that do not fit them."""
    primal, other = (noise(width, height, channels, seed + k) for k in (0, 1))
    return primal, differences(other, width)


def matrices(width, height):
    """D_x and D_y as matrices, of the differences that there are."""

    def steps(n):
        return sparse.diags([-1.0, 1.0], [0, 1], shape=(n - 1, n))

    across = sparse.kron(sparse.identity(height), steps(width)) if width > 1 else None
    down = sparse.kron(steps(height), sparse.identity(width)) if height > 1 else None
    return across, down


def inner(d, width):
    """The differences that there are, in the order of the matrices."""
    x, y = (a.reshape(-1, width, a.shape[1]) for a in (d.x, d.y))
    channels = d.x.shape[1]
    return x[:, :-1].reshape(-1, channels), y[:-1].reshape(-1, channels)


def sparse_solution(primal, d, width):
    """The same minimum, by a direct solver of the normal equations."""
    height = len(primal) // width
    left = ALPHA**2 * sparse.identity(len(primal))
    right = ALPHA**2 * primal
    for matrix, part in zip(matrices(width, height), inner(d, width), strict=True):
        if matrix is not None:
            left = left + matrix.T @ matrix
            right = right + matrix.T @ part
    left = left.tocsc()
    columns = [spsolve(left, right[:, c]) for c in range(primal.shape[1])]
    return np.stack(columns, axis=1)


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_it_is_the_solution_of_a_sparse_solver(width, height):
    primal, d = given(width, height)
    # The condition of the equations is (8 + α²) / α² = 201.
    room = 201 * 64 * EPS * np.abs(primal).max()
    found = least_squares(primal, d, width)
    assert_allclose(found, sparse_solution(primal, d, width), atol=room, rtol=0)


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_nothing_remains_of_the_normal_equations(width, height):
    primal, d = given(width, height)
    image = least_squares(primal, d, width)
    pulled = spread_back(differences(image, width), width)
    left = ALPHA**2 * image + pulled
    right = ALPHA**2 * primal + spread_back(d, width)
    assert_allclose(left, right, atol=200 * EPS * np.abs(image).max(), rtol=0)


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_the_mean_is_that_of_the_pixels(width, height):
    primal, d = given(width, height)
    found = least_squares(primal, d, width)
    assert_allclose(found.mean(axis=0), primal.mean(axis=0), rtol=1e-12)


@pytest.mark.parametrize("make", [least_squares, least_absolute])
@pytest.mark.parametrize(("width", "height"), SIZES)
def test_an_image_with_its_own_differences_comes_back(make, width, height):
    image = noise(width, height)
    found = make(image, differences(image, width), width)
    assert_allclose(found, image, atol=1e-12)


@pytest.mark.parametrize("make", [least_squares, least_absolute])
def test_a_constant_stays(make):
    flat = np.full((12 * 9, 3), 0.7)
    none = Differences(np.zeros_like(flat), np.zeros_like(flat))
    assert_allclose(make(flat, none, 12), flat, rtol=1e-13)


def test_it_is_linear():
    """So that it is unbiased where pixels and differences are."""
    (p, d), (q, e) = given(13, 8, seed=0), given(13, 8, seed=5)
    both = Differences(2 * d.x - 3 * e.x, 2 * d.y - 3 * e.y)
    found = least_squares(2 * p - 3 * q, both, 13)
    parts = 2 * least_squares(p, d, 13) - 3 * least_squares(q, e, 13)
    assert_allclose(found, parts, atol=1e-11)


def test_noisy_pixels_with_good_differences_become_a_good_image():
    truth = noise(40, 30, seed=3)
    rough = truth + np.random.default_rng(4).normal(size=truth.shape)
    found = least_squares(rough, differences(truth, 40), 40)
    # Of white noise α² / (α² + λ) remains at each frequency: few are low.
    before, after = ((a - truth).var() for a in (rough, found))
    assert after < before / 100


WRONG = {
    "axes swapped": lambda d: Differences(d.y, d.x),
    "signs turned": lambda d: Differences(-d.x, -d.y),
    "twice": lambda d: Differences(2 * d.x, 2 * d.y),
    "one pixel late": lambda d: Differences(np.roll(d.x, 1, 0), d.y),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_control_other_differences_make_another_image(wrong):
    """By more than a tenth of its contrast, where the right ones make it anew."""
    image = noise(16, 16)
    d = WRONG[wrong](differences(image, 16))
    x, y = (a.reshape(16, 16, 3).copy() for a in (d.x, d.y))
    x[:, -1], y[-1] = 0, 0
    bent = Differences(x.reshape(-1, 3), y.reshape(-1, 3))
    off = least_squares(image, bent, 16) - image
    assert off.std() > 0.1 * image.std()


def test_the_adjoint_is_one():
    """<D I, d> = <I, Dᵀ d>, for differences with anything at the borders."""
    image, other = noise(11, 7, seed=1), noise(11, 7, seed=2)
    d = Differences(other, noise(11, 7, seed=3))
    now = differences(image, 11)
    left = (now.x * d.x).sum() + (now.y * d.y).sum()
    assert left == pytest.approx((image * spread_back(d, 11)).sum(), rel=1e-13)


# ------------------------------------------------------------ least absolute values


def objective(image, primal, d, width):
    now = differences(image, width)
    parts = (ALPHA * (image - primal), now.x - d.x, now.y - d.y)
    return sum(np.linalg.norm(a, axis=1).sum() for a in parts)


def least_by_linear_programming(primal, d, width):
    """Least sum of absolute deviations of a grey image, exactly."""
    height, size = len(primal) // width, len(primal)
    across, down = matrices(width, height)
    a = sparse.vstack([ALPHA * sparse.identity(size), across, down])
    b = np.concatenate([ALPHA * primal[:, 0], *(p[:, 0] for p in inner(d, width))])
    # min 1·t with -t <= A x - b <= t.
    eye = sparse.identity(len(b))
    bounds = sparse.vstack([sparse.hstack([a, -eye]), sparse.hstack([-a, -eye])])
    cost = np.concatenate([np.zeros(size), np.ones(len(b))])
    limits = [(None, None)] * size + [(0, None)] * len(b)
    return linprog(cost, bounds, np.concatenate([b, -b]), bounds=limits).fun


@pytest.mark.parametrize("seed", range(5))
def test_no_image_is_much_better(seed):
    """What is left after all steps is below a thousandth."""
    primal, d = given(9, 8, channels=1, seed=10 * seed)
    found = objective(least_absolute(primal, d, 9), primal, d, 9)
    least = least_by_linear_programming(primal, d, 9)
    assert least * (1 - 1e-9) <= found <= least * 1.001
    # Control: least squares are further away than that.
    assert objective(least_squares(primal, d, 9), primal, d, 9) > least * 1.01


def test_one_wrong_difference_bends_the_squares_alone():
    truth = noise(20, 20, seed=6)
    d = differences(truth, 20)
    x = d.x.copy()
    x[205] += 50.0
    bent = Differences(x, d.y)
    squares, absolute = (
        make(truth, bent, 20) for make in (least_squares, least_absolute)
    )
    assert np.abs(squares - truth).max() > 5.0
    assert np.abs(absolute - truth).max() < 0.01


# ------------------------------------------------------------ what may not be given


@pytest.mark.parametrize("make", [least_squares, least_absolute])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["pixel", "difference x", "difference y"])
def test_what_is_not_finite_is_told_with_its_place(make, value, name):
    primal, d = given(12, 5)
    parts = {"pixel": primal, "difference x": d.x.copy(), "difference y": d.y.copy()}
    parts[name][3 * 12 + 7, 1] = value
    bent = Differences(parts["difference x"], parts["difference y"])
    with pytest.raises(ValueError, match=rf"{name} at \(7, 3\) is .* and 1 in all"):
        make(parts["pixel"], bent, 12)


def test_differences_that_lead_out_of_the_image_are_refused():
    primal, d = given(6, 4)
    x = d.x.copy()
    x[5] = 1.0
    with pytest.raises(ValueError, match="lead out of the image"):
        least_squares(primal, Differences(x, d.y), 6)
