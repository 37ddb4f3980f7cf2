"""How exact the Jacobian is at its extremes, in 16, 32 and 64 bits.

Judged in 50 digits, on the very numbers that the kernel is given: what is lost before,
when places are rounded to a short type far from the origin, is shown apart.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, dot
from restir_gi.reference.oracle.exact.numbers import EXACT, UNROUNDED, exactly
from restir_gi.reference.oracle.exact.targets import JACOBIAN
from restir_gi.reference.reports.figures.canvas import COLORS, blank, tidy
from restir_gi.reference.reports.figures.record import PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry
from restir_gi.reference.resampling.shift import reconnection_jacobian

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "extremes"
TYPES: tuple[Any, ...] = (np.float16, np.float32, np.float64)
RATIOS = np.arange(-6, 7)
"""Powers of two of d_to / d_from; their squares fit into half precision."""

COSINES = np.arange(0, -11, -1)
"""Powers of two of the cosine at which the receiver sees the patch."""

OFFSETS = np.arange(0, 21, 2)
"""Powers of two of how far from the origin a scene of one metre lies."""

ROUNDINGS, OF_CONDITION = 22, 4
"""(22 + 4 Σκ) eps bounds the relative error: 22 roundings at most follow one another,
and those before a cosine count κ times, κ = Σ |n_i v_i| / |n·v|."""


@dataclass(frozen=True, slots=True, eq=False)
class PatchGeometry:
    """Visible points x_from and x_to, and a sample point; (N, 3) float64 each."""

    x_from: Vec3s
    x_to: Vec3s
    position: Vec3s
    normal: Vec3s


def extremes(work: Work) -> PaperFigure:
    """Errors over distance and angle, and far from the origin; a row a type.

    Parameters
    ----------
    work : Work; ``runs`` geometries in each cell
    """
    errors, shares, curves, rows = {}, {}, {}, list[Row]()
    for done, dtype in enumerate(TYPES):
        work.tick(done, len(TYPES), "types")
        name = np.dtype(dtype).name
        errors[name], shares[name] = _over_distance_and_angle(dtype, work.runs)
        curves[name] = _far_from_the_origin(dtype, work.runs)
        kernel, places = curves[name]
        rows.append(
            {
                "type": name,
                "largest error, eps": float(errors[name].max()),
                "largest share of the bound": float(shares[name].max()),
                "error at 2^10 m, eps": float(kernel[OFFSETS == 10][0]),
                "relative error by places at 2^10 m": float(places[OFFSETS == 10][0]),
                "at 2^20 m": float(places[-1]),
            }
        )
    work.tick(len(TYPES), len(TYPES), "types")
    return PaperFigure(
        NAME,
        "The Jacobian at its extremes: error over distance, angle and offset",
        _picture(errors, shares, curves),
        tuple(rows),
        (
            f"Largest of {work.runs} geometries a cell. Error: |J - exact| / (eps"
            " exact), on the rounded inputs. Bound: (22 + 4 Σκ) eps, derived where the"
            " kernel is tested. Far from the origin the kernel is as exact as ever for"
            " the places that it is given, but these are no longer those of the scene:"
            " the last panel has the median of what that costs. Where points fall"
            " together, or places are beyond the type, J is wrong by 1.",
        ),
    )


def _over_distance_and_angle(dtype: Any, draws: int) -> tuple[Scalars, Scalars]:
    """Largest error in eps, and share of the bound, of each cell."""
    shape = len(COSINES), len(RATIOS)
    cosine, ratio = np.meshgrid(2.0**COSINES, 2.0**RATIOS, indexing="ij")
    cells = (np.repeat(a.ravel(), draws) for a in (cosine, ratio))
    error, share = _judged(_moved(_geometry(*cells), 0.0, dtype), dtype)
    largest = [a.reshape(*shape, draws).max(axis=2) for a in (error, share)]
    return largest[0], largest[1]


def _far_from_the_origin(dtype: Any, draws: int) -> tuple[Scalars, Scalars]:
    """Largest error in eps on the rounded places, and median relative error by them."""
    ones = np.ones(8 * draws)
    near = _geometry(0.5 * ones, ones)
    exact = _exact(near)
    kernel, places = [], []
    for power in OFFSETS:
        far = _moved(near, 2.0**power if power else 0.0, dtype)
        if not all(np.isfinite(a).all() for a in _parts(far)):
            kernel.append(0.0)
            places.append(1.0)
            continue
        kernel.append(float(_judged(far, dtype)[0].max()))
        off = [abs(float(a / b - 1)) for a, b in zip(_exact(far), exact, strict=True)]
        places.append(float(np.median(np.minimum(off, 1.0))))
    return np.array(kernel), np.array(places)


def _moved(g: PatchGeometry, offset: float, dtype: Any) -> PatchGeometry:
    """The same geometry away from the origin, rounded to a type; no J is changed."""
    moved = (g.x_from + offset, g.x_to + offset, g.position + offset, g.normal)
    with np.errstate(over="ignore"):
        return PatchGeometry(*(a.astype(dtype).astype(float) for a in moved))


def _geometry(cosine: Scalars, ratio: Scalars) -> PatchGeometry:
    """Patches seen at a cosine, from a distance of ratio times the source's."""
    rng = np.random.default_rng(0)
    count = len(cosine)

    def around(height: Scalars) -> Vec3s:
        phi = rng.uniform(0, 2 * np.pi, count)
        flat = np.sqrt(1 - height**2)
        return np.stack([flat * np.cos(phi), flat * np.sin(phi), height], axis=1)

    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    x_from = around(rng.uniform(0.3, 1.0, count)) @ turn
    x_to = ratio[:, None] * around(cosine) @ turn
    normal = np.tile(turn[2], (count, 1))
    return PatchGeometry(x_from, x_to, np.zeros((count, 3)), normal)


def _parts(g: PatchGeometry) -> tuple[Vec3s, Vec3s, Vec3s, Vec3s]:
    return g.x_from, g.x_to, g.position, g.normal


def _exact(g: PatchGeometry) -> list[Any]:
    """J of each row, mpf."""
    names = ("x_from", "x_to", "position", "normal")
    rows = zip(*_parts(g), strict=True)
    given = ((exactly(vector, UNROUNDED) for vector in row) for row in rows)
    return [JACOBIAN.formula(dict(zip(names, row, strict=True))).value for row in given]


def _judged(g: PatchGeometry, dtype: Any) -> tuple[Scalars, Scalars]:
    """Error of each row in eps, and as a share of the bound; 0 for rows without J."""
    found = reconnection_jacobian(*(a.astype(dtype) for a in _parts(g)))
    eps = EXACT.mpf(float(np.finfo(dtype).eps))
    error = np.array(
        [
            float(abs(EXACT.mpf(float(a)) - b) / (eps * b)) if b > 0 else 0.0
            for a, b in zip(found, _exact(g), strict=True)
        ]
    )
    bound = ROUNDINGS + OF_CONDITION * (_condition(g, g.x_from) + _condition(g, g.x_to))
    return error, error / bound


def _condition(g: PatchGeometry, eye: Vec3s) -> Scalars:
    parts = (eye - g.position) * g.normal
    height = np.abs(dot(eye - g.position, g.normal))
    known = height > 0
    found: Scalars = np.abs(parts).sum(axis=1) / np.where(known, height, 1.0)
    return np.where(known, found, np.inf)


def _picture(
    errors: dict[str, Scalars],
    shares: dict[str, Scalars],
    curves: dict[str, tuple[Scalars, Scalars]],
) -> "Figure":
    picture = blank(11, 8.2)
    axes = picture.subplots(3, 3)
    for column, name in enumerate(errors):
        _heat(axes[0, column], errors[name], f"{name}: error, eps")
        _heat(axes[1, column], shares[name], f"{name}: share of the bound")
    for index, (name, (kernel, places)) in enumerate(curves.items()):
        color = COLORS[index]
        axes[2, 0].plot(OFFSETS, kernel, "o-", color=color, label=name, markersize=3)
        seen = np.maximum(places, 1e-18)
        axes[2, 1].semilogy(OFFSETS, seen, "o-", color=color, label=name, markersize=3)
    x = "log2 of the offset, m"
    tidy(axes[2, 0], "kernel, on its places", x, "error, eps")
    tidy(axes[2, 1], "places, rounded", x, "relative error of J")
    axes[2, 1].legend(fontsize=7, frameon=False)
    axes[2, 2].set_visible(False)
    return picture


def _heat(axes: "Axes", values: Scalars, title: str) -> None:
    extent = (RATIOS[0] - 0.5, RATIOS[-1] + 0.5, COSINES[-1] - 0.5, COSINES[0] + 0.5)
    shown = axes.imshow(values, extent=extent, aspect="auto", cmap="viridis", vmin=0)
    axes.figure.colorbar(shown, ax=axes)
    tidy(axes, title, "log2 of d_to / d_from", "log2 cos φ_to")
    axes.grid(False)


FIGURE = FigureEntry(NAME, extremes, 32)
