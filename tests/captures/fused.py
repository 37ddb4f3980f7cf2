"""Engines that reuse time and space in one pass, and mistakes of theirs."""

import numpy as np

from tests.captures import mistakes
from tests.captures.engine import Engine, only


class FusedEngine(Engine):
    """The history and others beside it, all of the last frame.  One buffer a frame."""

    fused, around, size = True, 3, 48

    def sources(self, frame, x, x_before):
        """Rows of the last frame: where the pixel was, and some around it; or −1."""
        first = self.history(frame, x, x_before)
        y, column = np.divmod(np.maximum(first, 0), self.size)
        found = [first]
        for k in range(1, self.around):
            r = self.reach * np.sqrt(self.random(frame, 3, 2 * k))
            turn = 2 * np.pi * self.random(frame, 3, 2 * k + 1)
            i, j = (
                np.clip(at + np.rint(r * way).astype(int), 0, self.size - 1)
                for at, way in ((column, np.cos(turn)), (y, np.sin(turn)))
            )
            row = j * self.size + i
            use = (first >= 0) & self.alike(x, only(x_before, row)) & (row != first)
            found.append(np.where(use, row, -1))
        return np.stack(found, axis=1)

    def frame(self, frame):
        """One frame, and all buffers that it leaves."""
        x = self.gbuffer(frame)
        out = {"gbuffer": x, "initial": self.stored(self.initial(frame, x))}
        new = self.loaded(out["initial"])
        x_before = self.memory.get("gbuffer")
        if x_before is None:
            of, x_before = np.full((len(self.rows), self.around), -1), x
            past = {n: np.zeros_like(a) for n, a in new.items()}
        else:
            of, past = self.sources(frame, x, x_before), self.loaded(self.past(frame))
        out["sources"] = of
        out["fused"] = self.stored(self.reuse(frame, x, new, x_before, past, of))
        out["visible_fused"] = self.bits_fused(x, new, x_before, past, of)
        out["shade"] = self.shade(x, self.loaded(out["fused"]))
        out["visible_shade"] = Engine.sees(self, x, self.loaded(out["fused"]))
        self.memory |= {"gbuffer": x, "spatial": out["fused"]}
        return out

    def reuse(self, frame, x, new, x_before, past, of):
        """The new sample, then the sources."""
        candidates = [(x, new, np.ones(len(of), bool))]
        for k in range(of.shape[1]):
            at, there = np.maximum(of[:, k], 0), of[:, k] >= 0
            candidates.append((only(x_before, at), self.arrived(only(past, at)), there))
        return self.resample(x, candidates, lambda k: self.random(frame, 2, k))

    def bits_fused(self, x, new, x_before, past, of):
        """Who sees which: the pixel and its sources, the new sample and theirs."""
        rows = [np.maximum(of[:, k], 0) for k in range(of.shape[1])]
        viewers = [x, *(only(x_before, row) for row in rows)]
        return self._bits(viewers, [new, *(only(past, row) for row in rows)])


class SourceViewersForgotten(FusedEngine):
    """Sources are taken to stand where this frame has their pixels."""

    named = ("visible points of the sources are those of this frame",)

    def reuse(self, frame, x, new, x_before, past, of):
        """With this frame's visible points."""
        return super().reuse(frame, x, new, x, past, of)


def also(mistake, size=48):
    """A mistake of the engine of two passes, in this one."""
    return type(mistake.__name__, (mistake, FusedEngine), {"size": size})


MISTAKES = (
    SourceViewersForgotten,
    also(mistakes.JacobianLeftOut),
    also(mistakes.JacobianInverted),
    also(mistakes.DividedByConfidences),
    also(mistakes.BlindSources),
    also(mistakes.TargetOfSource),
    also(mistakes.WithoutConfidence),
    also(mistakes.SharedNumber, size=96),
    also(mistakes.NotSwapped),
)
