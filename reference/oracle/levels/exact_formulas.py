"""The kernels of the contract in exact numbers, from its words alone.

The formulas are those of the matrix of extremes,
:mod:`restir_gi.reference.oracle.exact`, on numbers that nothing rounds.  They share
nothing with the passes that are judged, nor with the replay that says how far rounding
may take them: what one of those has wrong, the other two show.
"""

from collections.abc import Callable, Mapping
from typing import Any

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.contract.surfaces import SURFACE
from restir_gi.reference.oracle.exact.geometry import similarity
from restir_gi.reference.oracle.exact.kernel import Kernel, Row
from restir_gi.reference.oracle.exact.numbers import UNROUNDED, Exact, exactly
from restir_gi.reference.oracle.exact.sampling import (
    COSINE_PDF,
    UNIFORM_PDF,
    azimuth,
    cosine_polar,
    uniform_polar,
)
from restir_gi.reference.oracle.exact.targets import (
    JACOBIAN,
    OUTGOING,
    REFLECTED,
    SCATTERED,
)
from restir_gi.reference.oracle.exact.weights import CHOICE, CONFIDENCE, FINALIZE
from restir_gi.reference.oracle.levels.exact_surfaces import (
    surface_reflected,
    surface_target,
)

Settings = Mapping[str, Value]
Formula = Callable[[Row, Settings], dict[str, Any]]
Polar = Callable[[Exact], tuple[Exact, Exact]]

TARGETS: Mapping[Value, Kernel] = {"scattered": SCATTERED, "outgoing": OUTGOING}
SOURCES: Mapping[Value, tuple[Polar, Kernel]] = {
    "uniform": (uniform_polar, UNIFORM_PDF),
    "cosine": (cosine_polar, COSINE_PDF),
}


def rows_of(case: Case) -> list[Row]:
    """What a case gives, row by row.

    Numbers that stay exact.  Rows of ``direction`` have an ``origin`` beside, the
    azimuth's random number in the first row that has their normal.
    """
    columns = {name: values.tolist() for name, values in case.inputs.items()}
    rows: list[Row] = [
        {name: exactly(column[k], UNROUNDED) for name, column in columns.items()}
        for k in range(case.rows)
    ]
    if case.pass_name != "direction":
        return rows
    first: dict[tuple[float, ...], Any] = {}
    normals = case.inputs["visible_normal"].tolist()
    return [
        {**row, "origin": first.setdefault(tuple(normal), row["u"][1])}
        for row, normal in zip(rows, normals, strict=True)
    ]


def _direction(row: Row, settings: Settings) -> dict[str, Any]:
    """The frame is the backend's own: azimuths are told from that of the origin."""
    polar, density = SOURCES[settings["source"]]
    cosine, _ = polar(row["u"][0])
    return {
        "cos θ": cosine,
        "length": 1,
        # The normal itself has none: 0 is as far from -1 as from 1.
        "azimuth": azimuth(row["u"][1] - row["origin"]).cos() if cosine < 1 else 0,
        "pdf": density.formula({"cosine": cosine}),
    }


def _target(row: Row, settings: Settings) -> dict[str, Any]:
    if SURFACE.name in settings and settings["target"] == "scattered":
        return {"p_hat": surface_target(row, settings[SURFACE.name])}
    return {"p_hat": TARGETS[settings["target"]].formula(row)}


def _shade(row: Row, settings: Settings) -> dict[str, Any]:
    if SURFACE.name in settings:
        f = surface_reflected(row, settings[SURFACE.name])
    else:
        f = REFLECTED.formula(row)
    seen = row.get("visible", 1)
    return {"color": tuple(c * row["W"] * seen for c in f)}


def _jacobian(row: Row, settings: Settings) -> dict[str, Any]:
    return {"jacobian": JACOBIAN.formula(row)}


def _merge(row: Row, settings: Settings) -> dict[str, Any]:
    return {
        "second": CHOICE.formula(row),
        "w": row["w_a"] + row["w_b"],
        "M": CONFIDENCE.formula(row),
    }


def _finalize(row: Row, settings: Settings) -> dict[str, Any]:
    return {"W": FINALIZE.formula(row)}


def _similar(row: Row, settings: Settings) -> dict[str, Any]:
    limits = float(settings["max_angle"]), float(settings["max_depth"])
    return {"similar": similarity(row, *limits)}


FORMULAS: Mapping[str, Formula] = {
    "direction": _direction,
    "target": _target,
    "jacobian": _jacobian,
    "merge": _merge,
    "finalize": _finalize,
    "similar": _similar,
    "shade": _shade,
}
"""By pass: a row and settings give what is compared, by the names of the judge."""
