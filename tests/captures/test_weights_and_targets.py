"""Captures of engines with weights of another kind, and with materials of their own."""

import numpy as np
import pytest

from restir_gi.reference.oracle.declaration.read import read_declaration
from tests.captures import mistakes
from tests.captures.dump import dump
from tests.captures.engine import Engine, GlossyEngine, only
from tests.captures.packed import F
from tests.captures.test_engine import said, verdict_on_folder

SIZE, FRAMES = 32, 3

DECLARATION = {
    "schema": "restir-declaration 1",
    "choices": {
        "generator": "own",
        "order": "own-first",
        "cap": "on arrival",
        "visibility": "shading",
    },
}
"""All that the engine says of itself but its weights, which the manifest has."""

DATA = DECLARATION | {
    "choices": DECLARATION["choices"] | {"mis": "balance", "mis_jacobian": False}
}


class OneMeasure(Engine):
    """Densities of the balance heuristic are compared in the measure of the pixel."""

    def source_density(self, x_from, x, kept):
        """Divided by the Jacobian."""
        p = super().source_density(x_from, x, kept)
        if x_from is x:
            return p
        J = self.jacobian(x_from, x, kept)
        return np.divide(p, J, out=np.zeros_like(p), where=J > 0)


def verdict_on(folder, declaration):
    return verdict_on_folder(folder, read_declaration(declaration))


def edited(folder, *changes):
    """A manifest with other words."""
    path = folder / "capture.toml"
    text = path.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return folder


@pytest.mark.parametrize(
    ("engine", "status"),
    [(OneMeasure, "PASS"), (mistakes.DividedByConfidences, "FAIL")],
)
def test_weights_may_be_those_of_the_manifest(tmp_path, engine, status):
    dump(engine(SIZE), tmp_path, FRAMES)
    edited(tmp_path, ("surface =", 'mis = "balance"\nsurface ='))
    verdict = verdict_on(tmp_path, DECLARATION)
    assert verdict.status == status, said(verdict)
    names = {h.name for d in verdict.departures for h in d.matches}
    assert not any("balance" in name for name in names)


# ---------------------------------------------------------------- targets as data

BUFFER = """
[buffers.{role}]
file = "{role}.{{frame}}.bin"
fields = [{{ name = "p_hat", kind = "float32", count = {count} }}]
"""


def targets(engine, viewers, samples):
    """Targets of samples at visible points, (N, V, S)."""
    found = [[engine.target(x, y) for y in samples] for x in viewers]
    return np.array(found, F).transpose(2, 0, 1)


def dump_targets(engine, folder):
    """The targets of all samples, beside a dump of what was seen and kept."""
    before = None
    for number, out in enumerate(engine.frames):
        x, new = out["gbuffer"], engine.loaded(out["initial"])
        own, around = engine.loaded(out["temporal"]), out["neighbors"]
        none = {name: np.zeros_like(a) for name, a in new.items()}
        x_past, past = x, none
        if before is not None:
            at = np.maximum(out["history"], 0)
            x_past = only(before["gbuffer"], at)
            past = only(engine.loaded(before["spatial"]), at)
        rows = [np.maximum(around[:, k], 0) for k in range(around.shape[1])]
        viewers = [x, *(only(x, row) for row in rows)]
        samples = [own, *(only(own, row) for row in rows), none]
        for role, array in (
            ("targets_moved", targets(engine, (x, x_past), (new, past))),
            ("targets_spatial", targets(engine, viewers, samples)),
        ):
            (folder / f"{role}.{number}.bin").write_bytes(array.tobytes())
        before = out
    count = engine.around + 1
    more = BUFFER.format(role="targets_moved", count=4)
    more += BUFFER.format(role="targets_spatial", count=count * (count + 1))
    text = (folder / "capture.toml").read_text()
    first, last = text.index("[buffers.visible_shade]"), text.index("[buffers.view]")
    text = (text[:first] + more).replace('surface = "ggx"', 'target = "data"')
    assert last > first  # what stands from there on is shading, and materials
    (folder / "capture.toml").write_text(text)


class LobesForgotten(GlossyEngine):
    """Reused samples have the target of a diffuse surface."""

    def weight(self, x_from, x, r):
        """Of the diffuse part alone."""
        J = F(1) if x_from is x else self.jacobian(x_from, x, r)
        p_hat = Engine.target(Diffuse(self.size), x, r)
        return np.where(r["W"] > 0, p_hat * r["W"] * r["M"] * J, F(0))


class Diffuse(Engine):
    """Without any lobe."""


@pytest.mark.parametrize(
    ("engine", "status"), [(GlossyEngine, "PASS"), (LobesForgotten, "FAIL")]
)
def test_materials_may_be_the_engines_own(tmp_path, engine, status):
    one = engine(SIZE)
    dump(one, tmp_path, FRAMES)
    dump_targets(one, tmp_path)
    verdict = verdict_on(tmp_path, DATA)
    assert verdict.status == status, said(verdict)
    assert verdict.judged == {"moved", "spatial"}
