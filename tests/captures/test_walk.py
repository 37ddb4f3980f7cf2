"""An RTXDI integration, judged in ten minutes: the walk of the page, and its clock."""

import re
import time
from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.oracle.capture.record import Capture
from tests.captures.dump import in_blocks
from tests.captures.mistakes import BlindSources, TemporalAgain
from tests.captures.packed import F
from tests.captures.room import unit

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "rtxdi.md"
SIZE, FRAMES, TEN_MINUTES = 48, 4, 600.0
FAR = F(65504)


def small_floats(rgb):
    """Colours below 1 as 11, 11 and 10 bits of floats, and what these mean."""
    words, meant = np.zeros(len(rgb), np.uint32), np.zeros_like(rgb)
    for k, (bits, shift) in enumerate(((6, 0), (6, 11), (5, 22))):
        exponent = np.floor(np.log2(np.maximum(rgb[:, k], F(2**-14))))
        steps = np.floor((rgb[:, k] / 2**exponent - 1) * 2**bits)
        there = rgb[:, k] > 0
        code = (exponent + 15).astype(np.uint32) << np.uint32(bits)
        code |= np.maximum(steps, 0).astype(np.uint32)
        words |= np.where(there, code, 0).astype(np.uint32) << np.uint32(shift)
        meant[:, k] = np.where(there, 2**exponent * (1 + steps / 2**bits), 0)
    return words, meant


def octahedral(n):
    """Normals as two numbers of 0 to 65534, and what these mean; 0 for none."""
    seen = n.any(axis=1)
    n = np.where(seen[:, None], n, F(1))
    x, y, z = (n / np.abs(n).sum(axis=1, keepdims=True)).T
    side = [np.where(a >= 0, F(1), F(-1)) for a in (x, y)]
    folded = [(1 - np.abs(b)) * s for b, s in ((y, side[0]), (x, side[1]))]
    p = np.column_stack(
        [np.where(z < 0, f, a) for f, a in zip(folded, (x, y), strict=True)]
    )
    codes = np.rint((p * F(0.5) + F(0.5)) * 65534).astype(np.uint32)
    p = codes.astype(F) / F(65534) * 2 - 1
    up = 1 - np.abs(p).sum(axis=1)
    back = np.where(p >= 0, F(1), F(-1)) * (1 - np.abs(p[:, ::-1]))
    xy = np.where((up < 0)[:, None], back, p)
    meant = unit(np.column_stack([xy, up]).astype(F)).astype(F)
    return codes[:, 0] | codes[:, 1] << np.uint32(16), np.where(seen[:, None], meant, 0)


class Integration(BlindSources):
    """The G-buffer in the bits of RTXDI's sample, and bias correction "basic"."""

    cap = F(8)

    def gbuffer(self, frame):
        """What the shaders read of these bits."""
        x = super().gbuffer(frame)
        normals, normal = octahedral(x["normal"])
        colors, albedo = small_floats(x["albedo"])
        return x | {
            "normal": normal.astype(F),
            "albedo": albedo.astype(F),
            "bits": np.column_stack([normals, colors]),
        }

    def alike(self, a, b):
        """No pixel without a surface."""
        return super().alike(a, b) & (a["depth"] > 0) & (b["depth"] > 0)


class WrongIntegration(TemporalAgain, Integration):
    """The past is read from the wrong buffer."""


def copied(engine, folder):
    """The files that the list of the folder asks for."""
    for frame, b in enumerate(engine.run(FRAMES)):
        x = b["gbuffer"]
        depth = np.where(x["depth"] > 0, x["depth"], FAR)
        files = {
            "gbuffer-position": np.column_stack([x["position"], depth]),
            "gbuffer-normal": x["bits"][:, 0].copy(),
            "gbuffer-albedo": x["bits"][:, 1].copy(),
            "gbuffer-depth": depth.astype(F),
            "history": b["history"].astype(np.int32),
            "neighbors": b["neighbors"].astype(np.int32),
        }
        files |= {n: in_blocks(b[n], SIZE) for n in ("initial", "temporal", "spatial")}
        for name, array in files.items():
            (folder / f"{name}.{frame}.bin").write_bytes(array.tobytes())


def commands():
    """What the page tells to type, as lists of words."""
    return [
        line.removeprefix("restir ").split()
        for block in re.findall(r"```sh\n(.*?)```", PAGE.read_text("utf-8"), re.S)
        for line in block.strip().splitlines()
    ]


def walk(engine, capsys):
    """All steps of the page; the exit code, and what the verdict says."""
    begin, judge = commands()
    begin[begin.index("--size") + 1] = f"{SIZE}x{SIZE}"
    assert main(begin) == 0
    copied(engine, Path("capture"))
    declaration = Path("capture", "declaration.toml")
    text = declaration.read_text("utf-8").replace("# accept = ", "accept = ")
    # This one has neither a filter nor a limit of age.
    text = re.sub("^(boiling|max_age|refused|clamped) .*\n", "", text, flags=re.M)
    text = re.sub(
        "^accept = .*$", 'accept = ["visibility-missing-in-z"]', text, flags=re.M
    )
    declaration.write_text(text, "utf-8")
    capsys.readouterr()
    code = main(judge)
    told = capsys.readouterr()
    return code, told.out + told.err


def test_a_right_integration_passes_within_ten_minutes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert len(commands()) == 2
    began = time.monotonic()
    code, text = walk(Integration(SIZE), capsys)
    assert code == 0, text
    assert time.monotonic() - began < TEN_MINUTES
    assert "biased by design in visibility-missing-in-z" in text
    assert Path("report", "index.html").exists()


@pytest.mark.slow
def test_control_a_wrong_integration_is_named(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code, text = walk(WrongIntegration(SIZE), capsys)
    assert code == 1
    assert "temporal reservoirs of the last frame" in text


@pytest.mark.slow
def test_no_surface_is_seen_where_the_depth_says_so(tmp_path, monkeypatch, capsys):
    """Whatever bits of a normal stand there."""
    monkeypatch.chdir(tmp_path)
    walk(Integration(SIZE), capsys)
    gbuffer = Capture.read(Path("capture")).frames[1]["gbuffer"]
    nothing = gbuffer["depth"] == 0
    bits = np.fromfile(Path("capture", "gbuffer-normal.1.bin"), np.uint32)
    assert 100 < nothing.sum() < SIZE * SIZE - 100
    assert bits[nothing].all()
    assert (gbuffer["visible_normal"].any(axis=1) == ~nothing).all()
