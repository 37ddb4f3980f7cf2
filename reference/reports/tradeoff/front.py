"""Which points are worth taking, and the one to take."""

from collections.abc import Sequence

import numpy as np

from restir_gi.reference.reports.tradeoff.scores import DesignScore


def on_front(scores: Sequence[DesignScore]) -> list[bool]:
    """Whether no other point is as good in everything and better in something.

    By time, bias and standard deviation, as they were measured; the bias is that which
    is certain, so that noise makes nobody worse.
    """
    rows = np.array([(s.ms.value, s.bias, s.error.variance.value) for s in scores])
    as_good = (rows[:, None] <= rows).all(axis=2)
    better = (rows[:, None] < rows).any(axis=2)
    dominated = np.any(as_good & better, axis=0)
    return [not d for d in dominated.tolist()]


def best_within(scores: Sequence[DesignScore], ms: float) -> DesignScore | None:
    """Point of the least error that a frame's time allows; None if all take longer.

    Parameters
    ----------
    ms : float; a frame may take
    """
    allowed = [s for s in scores if s.ms.value <= ms]
    return min(allowed, key=lambda s: s.error.mse.value, default=None)


def fastest_for(scores: Sequence[DesignScore], mse: float) -> DesignScore | None:
    """Point of the least time that makes an error small enough.

    None if none is so exact.

    Parameters
    ----------
    mse : float, (W/(m² sr))²; of one frame, at most
    """
    allowed = [s for s in scores if s.error.mse.value <= mse]
    return min(allowed, key=lambda s: s.ms.value, default=None)


def advice(
    scores: Sequence[DesignScore], light: float, percent: float | None, ms: float | None
) -> str:
    """The sentence at the end: what to take for that error, and what in that time.

    Parameters
    ----------
    scores : sequence of DesignScore; measured; the first is the base
    light : float; mean of the truth
    percent : float, optional
        Error that is allowed, of the mean; by default that of the base.
    ms : float, optional; time that is allowed; by default that of the base
    """
    base = scores[0]
    percent = rms_percent(base, light) if percent is None else percent
    ms = base.ms.value if ms is None else ms
    exact = fastest_for(scores, (percent / 100 * light) ** 2)
    fast = best_within(scores, ms)
    return (
        f"For an error of {percent:.3g} % of the mean light take"
        f" {_told(exact, light, 'no setting here is so exact')}; in {ms:.3g} ms a frame"
        f" take {_told(fast, light, 'no setting here is so fast')}."
    )


def rms_percent(score: DesignScore, light: float) -> float:
    """Root mean squared error of a frame, as a share of the mean light.

    In percent; 0 where there is no light at all.

    Parameters
    ----------
    light : float; mean of the truth
    """
    mse = max(score.error.mse.value, 0.0)
    return float(100 * np.sqrt(mse) / light) if light > 0 else 0.0


def _told(score: DesignScore | None, light: float, none: str) -> str:
    if score is None:
        return f"something else ({none})"
    words = " ".join(score.point.values) or "as it is"
    error = rms_percent(score, light)
    return f"{score.point.method} {words} ({score.ms.value:.3g} ms, {error:.3g} %)"
