"""What a sweep has found, and on which machine."""

from dataclasses import dataclass

from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.reports.tradeoff.change import Recovery
from restir_gi.reference.reports.tradeoff.front import advice
from restir_gi.reference.reports.tradeoff.scores import DesignScore
from restir_gi.reference.reports.tradeoff.sweep import Sweep


@dataclass(frozen=True, slots=True, eq=False)
class Results:
    """What a sweep has found.

    Attributes
    ----------
    sweep : Sweep; what was measured
    scores : list of DesignScore; one a point, the first that of the base
    recoveries : list of Recovery
        After a change of light; none where the scene changes by itself.
    percent, ms : float or None; error and time that the user allows
    """

    sweep: Sweep
    truth: Moments
    scores: list[DesignScore]
    recoveries: list[Recovery]
    percent: float | None
    ms: float | None

    @property
    def light(self) -> float:
        """Mean of the truth."""
        return float(self.truth.mean.mean())

    @property
    def once(self) -> list[DesignScore]:
        """Scores of points that differ in what they do, not only in name."""
        found: dict[str, DesignScore] = {}
        for score in self.scores:
            found.setdefault(score.point.key, score)
        return list(found.values())

    @property
    def groups(self) -> list[tuple[str, list[DesignScore]]]:
        """Scores by the knob that was turned."""
        names = dict.fromkeys(s.point.knob for s in self.scores if s.point.knob)
        return [(n, [s for s in self.scores if s.point.knob == n]) for n in names]

    @property
    def advice(self) -> str:
        """The sentence at the end."""
        return advice(self.once, self.light, self.percent, self.ms)
