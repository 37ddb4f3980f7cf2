"""A verdict on pictures for programs: text, numbers, lists and dicts alone."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from restir_gi.reference.oracle.blackbox.evidence import (
    MISSED,
    PictureDifferences,
    p_values,
    share_of,
    within,
)
from restir_gi.reference.oracle.blackbox.judge import (
    DEVIATIONS,
    Look,
    PicturesVerdict,
    accused_first,
)
from restir_gi.reference.oracle.blackbox.tiles import PLACES, TILES, name_of
from restir_gi.reference.reports.verdict.rows import as_number
from restir_gi.reference.reports.verdict.schema import VERSION

NEGATIVE = (
    "pixels of these pictures are negative: what rests on light that is never negative"
    " was not used"
)


def as_plain(
    verdict: PicturesVerdict,
    name: str,
    seconds: float,
    asked_for: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """A verdict on pictures for programs.

    JSON can hold it; numbers that are not finite are ``None``.

    Parameters
    ----------
    name : str; command line of the renderer
    seconds : float; that it took to come to the verdict
    asked_for : mapping, optional; options of the check that decide what is asked
    """
    asked, truth = verdict.convention, verdict.truth
    columns = _worst_first(verdict)
    pixels = verdict.pixels
    return {
        **head(verdict.status, name, _headline(verdict), asked_for),
        "seconds": as_number(seconds),
        "pictures": 0 if pixels is None else pixels.count,
        "size": list(truth.size),
        "convention": {
            "light": asked.light,
            "bounces": asked.bounces,
            "pixel": asked.pixel,
            "words": asked.words,
            "options": asked.options,
        },
        "tolerance": {"whole": verdict.tolerance.whole, "tile": verdict.tolerance.tile},
        "alpha": verdict.alpha,
        "bound": verdict.bound,
        "missed": MISSED,
        "truth": {
            "mean": as_number(truth.mean[0]),
            "error": as_number(truth.standard_error[0]),
            "samples": truth.samples,
        },
        "means": _means(verdict, columns),
        "evidence": verdict.evidence,
        "accuses": _accuses(verdict),
        "negative": NEGATIVE if verdict.negative else None,
        "likenesses": [one.sentence for one in verdict.likenesses],
        "wanted": verdict.wanted,
        "looks": [
            _look(number, look, columns, verdict.alpha)
            for number, look in enumerate(verdict.looks, 1)
        ],
    }


def head(
    status: str, name: str, headline: str, asked_for: Mapping[str, Any] | None
) -> dict[str, Any]:
    """What every verdict on pictures says, also one without a picture."""
    return {
        "schema": VERSION,
        "kind": "pictures",
        "status": status,
        "backend": name,
        "headline": headline,
        "asked": dict(asked_for or {}),
    }


def _headline(verdict: PicturesVerdict) -> str:
    """One line: what others have written may have several.

    A convention is named where it is the only one with which the pictures agree.
    """
    likely = [one.sentence for one in verdict.likenesses]
    named = likely if len(likely) == 1 else []
    return " ".join("; ".join([verdict.sentence, *named]).split())


def _worst_first(verdict: PicturesVerdict) -> list[int]:
    """The picture, and then its tiles, those first that are the least likely.

    Of some that are impossible, those that are off the most of what is let pass.  Where
    channels alone are wrong, the worst comes second.
    """
    if not verdict.looks:
        return list(range(PLACES))
    last = verdict.looks[-1].differences
    margins = verdict.tolerance.margins(verdict.truth)
    never = np.where(last.difference != 0, np.inf, 0.0)
    off = np.divide(np.abs(last.difference), margins, out=never, where=margins > 0)
    p = p_values(last)
    order = np.lexsort((-off, p)).tolist()
    tiles = [column for column in order if 0 < column < PLACES]
    channels = [column for column in order if column >= PLACES]
    p_accuses = verdict.alpha / 2 * share_of(len(verdict.looks))
    alone = accused_first(last, p_accuses) >= PLACES
    return [0, *(channels[:1] if alone else []), *tiles]


def _means(verdict: PicturesVerdict, columns: list[int]) -> list[dict[str, Any]]:
    """Of the picture and of its tiles, the worst first, after the last look."""
    if not verdict.looks:
        return []
    last, look = verdict.looks[-1].differences, len(verdict.looks)
    margins = verdict.tolerance.margins(verdict.truth)
    is_within = within(last, margins, MISSED * share_of(look))
    p = p_values(last)
    return [
        {
            **_place(column),
            "truth": as_number(last.truth[column]),
            "truth_error": as_number(verdict.truth.standard_error[column]),
            **_difference(last, column),
            "p": as_number(p[column]),
            "margin": as_number(margins[column]),
            "within": bool(is_within[column]),
        }
        for column in columns
    ]


def _place(column: int) -> dict[str, Any]:
    """Which mean it is; a tile with its column and its row."""
    row, place = divmod(column - 1, TILES)
    is_tile = 0 < column < PLACES
    return {
        "name": name_of(column),
        "x": place if is_tile else None,
        "y": row if is_tile else None,
    }


def _difference(found: PictureDifferences, column: int) -> dict[str, Any]:
    """A mean minus its truth, and its standard error; also as shares of the truth."""
    truth, error = found.truth[column], found.error[column]
    return {
        "difference": as_number(found.difference[column]),
        "error": as_number(error),
        "relative": as_number(found.relative[column]),
        "relative_error": as_number(error / truth) if truth > 0 else None,
        "deviations": as_number(found.difference[column] / error)
        if error > 0
        else None,
    }


def _look(number: int, look: Look, columns: list[int], alpha: float) -> dict[str, Any]:
    """What was known after some pictures, of the picture and of the worst tile."""
    found = look.differences
    return {
        "pictures": found.count,
        **_difference(found, 0),
        "worst_tile": {**_place(columns[1]), **_difference(found, columns[1])},
        "p": as_number(look.p),
        "p_accuses": alpha / 2 * share_of(number),
        "e": as_number(look.e),
        "e_accuses": 2 / alpha,
    }


def _accuses(verdict: PicturesVerdict) -> str:
    """Which evidence accuses, and what it rests on."""
    if verdict.evidence == "broken":
        return "what the renderer does with its pictures, whatever light is in them"
    if not verdict.evidence:
        return "nothing"
    look = verdict.looks[-1]
    if verdict.evidence == "statistical":
        return (
            "statistical evidence, which rests on noise of a finite variance: of a"
            " right renderer, one of the means is so far off with probability"
            f" {look.p:.1g}"
        )
    odds = f"{1 / look.e:.1g}" if np.isfinite(look.e) else "0"
    return (
        f"proven evidence, which rests on {_proven(verdict)}: bets against a right"
        f" renderer win so much with probability {odds}"
    )


def _proven(verdict: PicturesVerdict) -> str:
    """What the proof takes for granted."""
    truths = f"truths that are not off by {DEVIATIONS:g} of their errors"
    if verdict.bound is None:
        return f"light that is never negative and on {truths}, whatever the noise"
    return (
        f"light that is never negative, on {truths}, and on your word that no mean of"
        f" a tile exceeds {verdict.bound:g} times its truth"
    )
