"""The results of a sweep as numbers for programs: JSON, CSV, and a table to be read."""

import csv
from io import StringIO
from typing import Any

import numpy as np
from rich.table import Table

from restir_gi.reference.numerics.intervals import Interval
from restir_gi.reference.reports.tradeoff.front import on_front, rms_percent
from restir_gi.reference.reports.tradeoff.results import Results
from restir_gi.reference.reports.tradeoff.scores import DesignScore
from restir_gi.reference.system.machine import machine


def as_plain(results: Results) -> dict[str, Any]:
    """All numbers, for JSON.

    Intervals are [value, low, high]; of times the median and the quartiles, of all else
    95 %.
    """
    sweep = results.sweep
    return {
        "scene": sweep.named.name,
        "width": sweep.named.width,
        "height": sweep.named.height,
        "frame": sweep.named.frame,
        "bounces": sweep.bounces,
        "frames": sweep.frames,
        "runs": sweep.runs,
        "seed": sweep.seed,
        "truth": {
            "samples": results.truth.count,
            "mean": results.light,
            "variance": float(np.mean(results.truth.standard_error() ** 2.0)),
        },
        "machine": machine(),
        "points": rows(results),
        "after a change of light": [
            {
                "label": r.point.label,
                "method": r.point.method,
                "settings": list(r.point.values),
                "error": r.error.tolist(),
                "mean": r.mean.tolist(),
            }
            for r in results.recoveries
        ],
        "advice": results.advice,
    }


def rows(results: Results) -> list[dict[str, Any]]:
    """Numbers of all points."""
    once = results.once
    best = {s.point.key for s, good in zip(once, on_front(once), strict=True) if good}
    return [_row(s, results.light, s.point.key in best) for s in results.scores]


def _row(score: DesignScore, light: float, is_best: bool) -> dict[str, Any]:
    return {
        "knob": score.point.knob,
        "label": score.point.label,
        "method": score.point.method,
        "settings": list(score.point.values),
        "ms": _ends(score.ms),
        "rays": score.rays,
        "bytes": score.kept,
        "MSE": _ends(score.error.mse),
        "bias2": _ends(score.error.bias2),
        "variance": _ends(score.error.variance),
        "rms_percent": rms_percent(score, light),
        "deviation": [score.deviation.value, score.deviation.error],
        "correlation_length": _ends(score.length),
        "lag": _ends(score.lag),
        "worst_thousandth": score.worst,
        "front": is_best,
    }


def as_csv(results: Results) -> str:
    """The same points, a line each, for spreadsheets.

    The first line names the columns.
    """
    lines = [_flat(numbers) for numbers in rows(results)]
    names = list(dict.fromkeys(name for line in lines for name in line))
    buffer = StringIO()
    writer = csv.DictWriter(buffer, names, restval="0", lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    return buffer.getvalue()


def _flat(numbers: dict[str, Any]) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in numbers.items():
        if name == "settings":
            flat[name] = " ".join(value)
        elif name == "rays":
            flat |= {f"rays.{kind}": count for kind, count in value.items()}
        elif name == "deviation":
            flat |= {name: value[0], f"{name}.error": value[1]}
        elif isinstance(value, list):
            flat |= {name: value[0], f"{name}.low": value[1], f"{name}.high": value[2]}
        else:
            flat[name] = value
    return flat


COLUMNS = (
    "knob",
    "set to",
    "ms",
    "rays",
    "bytes",
    "error",
    "bias²",
    "length",
    "lag",
    "",
)


def cells(results: Results) -> list[tuple[str, ...]]:
    """The points as text, a cell a column, in the order of `COLUMNS`.

    The error is the root of the MSE over the mean light; the squared bias is a share of
    the MSE, with its interval.
    """
    found: list[tuple[str, ...]] = []
    for score, numbers in zip(results.scores, rows(results), strict=True):
        mse, bias2 = score.error.mse.value, score.error.bias2
        share = [100 * x / mse if mse > 0 else 0.0 for x in _ends(bias2)]
        found.append(
            (
                score.point.knob,
                score.point.label,
                f"{score.ms.value:.3g}",
                f"{score.all_rays:.3g}",
                f"{score.kept:.0f}",
                f"{numbers['rms_percent']:.3g} %",
                f"{share[0]:+.2g} % [{share[1]:+.2g}, {share[2]:+.2g}]",
                f"{score.length.value:.2g}",
                f"{score.lag.value:.2g}",
                "front" if numbers["front"] else "",
            )
        )
    return found


def table(results: Results) -> Table:
    """The points as a table for a terminal."""
    made = Table(title=f"Speed against accuracy: {results.sweep.named.name}")
    for index, column in enumerate(COLUMNS):
        made.add_column(column, justify="left" if index < 2 else "right")
    for line in cells(results):
        made.add_row(*line)
    return made


def _ends(interval: Interval) -> list[float]:
    return [interval.value, interval.low, interval.high]
