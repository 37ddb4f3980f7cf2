"""The further passes of the contract: who is right passes, and mistakes are found."""

import re
from functools import cache

import numpy as np
import pytest

from restir_gi.reference.numerics.rng import pcg4d, to_unit_interval
from restir_gi.reference.oracle.builtin.further import FURTHER
from restir_gi.reference.oracle.cases import pass_of, refused
from restir_gi.reference.oracle.contract.fields import dtype_of
from restir_gi.reference.oracle.contract.further import FURTHER_PASSES
from restir_gi.reference.oracle.diagnosis.diagnose import HYPOTHESES, diagnose
from restir_gi.reference.oracle.diagnosis.further import FURTHER_MISTAKES
from restir_gi.reference.oracle.diagnosis.further_layouts import LAYOUT_MISTAKES
from restir_gi.reference.oracle.levels.further import further_cases
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.replay.further.judges import FURTHER_JUDGES
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world
from tests.contracts.other_packing import pack, units, unpack

PASSES = {p.name: p for p in FURTHER_PASSES}
WEIGHTS = np.array([0.2126, 0.7152, 0.0722])

both_precisions = pytest.mark.parametrize("precision", ["float32", "float64"])
every_pass = pytest.mark.parametrize("name", PASSES)


@cache
def cases(precision, name):
    """Cases of one pass."""
    return [c for c in further_cases(precision) if c.pass_name == name]


def judgements(precision, name, backend):
    """What the judge makes of a backend, a judgement a case, and none if refused."""
    found = []
    for case in cases(precision, name):
        with np.errstate(all="ignore"):
            raw = backend(**case.inputs, **case.settings)
        outputs = pass_of(PASSES, case).outputs
        fields = {f.name: dtype_of(f.kind, precision) for f in outputs}
        out = {n: np.ascontiguousarray(raw[n], dtype) for n, dtype in fields.items()}
        if refused(PASSES, case, precision, out) is not None:
            found.append(None)
            continue
        judge = FURTHER_JUDGES[name]
        found.append(judge(case, out, CONTRACT_RULES, precision))
    return found


# ------------------------------------------------ another backend, in its own type


def dots(a, b):
    """Summed backwards."""
    return a[..., 2] * b[..., 2] + a[..., 1] * b[..., 1] + a[..., 0] * b[..., 0]


def frame_of(real, mistake, s):
    """Pinhole and axes."""
    vectors = [[s[f"{n}_{axis}"] for axis in "xyz"] for n in ("eye", "target", "up")]
    eye, target, up = (np.array(v, real) for v in vectors)
    forward = units(target - eye)
    right = units(np.cross(forward, up))
    upward = up if mistake == "up as it is" else np.cross(right, forward)
    return eye, right, upward, forward, np.tan(real(np.radians(s["fov_x"]) / 2))


def gbuffer(real, mistake, pixel, a, b, c, **s):
    """Rays of length 1 and the intersection of Möller and Trumbore."""
    eye, right, upward, forward, h = frame_of(real, mistake, s)
    width, height = real(s["width"]), real(s["height"])
    x, y = (v.astype(real) for v in (pixel % s["width"], pixel // s["width"]))
    if mistake != "corner of the pixel":
        x, y = x + real(0.5), y + real(0.5)
    rise = height / 2 - y
    if mistake == "y counts upwards":
        rise = -rise
    if mistake == "angle of the height":
        h = h * width / height
    across, rise = (x - width / 2) * (2 * h / width), rise * (2 * h / width)
    d = units(across[:, None] * right + rise[:, None] * upward + forward)
    edge_b, edge_c = b - a, c - a
    p = np.cross(d, edge_c)
    determinant = dots(edge_b, p)
    q = np.cross(eye - a, edge_b)
    inverse = np.where(determinant != 0, 1 / determinant, 0).astype(real)
    u, v = dots(eye - a, p) * inverse, dots(d, q) * inverse
    distance = dots(edge_c, q) * inverse
    hit = (u > 0) & (v > 0) & (u + v < 1) & (distance > 0)
    if mistake == "behind":
        hit |= (u > 0) & (v > 0) & (u + v < 1)
    if mistake == "back faces are not met":
        hit &= determinant > 0
    if mistake == "parallelogram":
        hit = (u > 0) & (v > 0) & (u < 1) & (v < 1) & (distance > 0)
    normal = units(np.cross(edge_b, edge_c))
    if mistake != "normal of the front":
        normal = np.where((dots(normal, d) > 0)[:, None], -normal, normal)
    depth = distance * (1 if mistake == "distance" else dots(d, forward))
    found = {"position": eye + d * distance[:, None], "normal": normal, "depth": depth}
    if mistake == "misses keep their numbers":
        return {"hit": hit, **{n: np.nan_to_num(v) for n, v in found.items()}}
    return {"hit": hit, **{n: np.where(hit, v.T, 0).T for n, v in found.items()}}


def reproject(real, mistake, position, normal, hit, normal_before, depth_before, **s):
    """A matrix of the view, applied to points before the pinhole is taken away."""
    eye, right, upward, forward, h = frame_of(real, mistake, s)
    width, height = s["width"], s["height"]
    view = np.stack([right, upward, forward])
    x, y, depth = (position @ view.T - view @ eye).T
    front = (depth > 0) | (mistake == "behind")
    safe = np.where(depth != 0, depth, 1)
    x = (x / (safe * h) + 1) * real(width / 2)
    y = real(height / 2) - y / (safe * h) * real(width / 2)
    if mistake == "half a pixel":
        x, y = x - real(0.5), y - real(0.5)
    if mistake == "y counts upwards":
        y = height - y
    whole = {"rounds": np.rint, "truncates": np.trunc}.get(mistake, np.floor)
    x, y = (whole(v).clip(-1e6, 1e6).astype(int) for v in (x, y))
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    if mistake == "clamped to the image":
        x, y, inside = x.clip(0, width - 1), y.clip(0, height - 1), True
    if mistake == "behind":
        depth = abs(depth)
    row = np.where(inside, y * width + x, 0)
    before = depth_before[row]
    if mistake == "distance":
        depth = np.sqrt(dots(position - eye, position - eye))
    scale = np.maximum(depth, before) if mistake != "relative to its own" else depth
    change = abs(depth - before) if mistake != "one side" else depth - before
    alike = change / np.where(scale != 0, scale, 1) <= real(s["max_depth"])
    if mistake != "normals are not compared":
        least = np.cos(real(np.radians(s["max_angle"])))
        alike &= dots(normal, normal_before[row]) >= least
    seen = (hit == 1) | (mistake == "misses go on")
    alike &= before > 0
    return {"row": np.where(seen & front & inside & alike, row, -1)}


def validation(real, mistake, W, M, radiance_then, radiance_now, met, null, tolerance):
    """Luminance summed backwards, and a quotient in place of a product."""
    a, b = (dots(v, WEIGHTS.astype(real)) for v in (radiance_then, radiance_now))
    change = abs(a - b)
    if mistake == "only what darkens":
        change = a - b
    if mistake == "only what brightens":
        change = b - a
    most = {"relative to then": a, "relative to now": b}.get(mistake, np.maximum(a, b))
    nothing = np.where(change > 0, np.inf, 0).astype(real)
    relative = np.divide(change, most, out=nothing, where=most > 0)
    alike = relative <= real(tolerance)
    if mistake == "strict":
        alike = relative < real(tolerance)
    stays = alike & ((met == 1) | (mistake == "no ray"))
    if mistake != "nulls are asked":
        stays |= null == 1
    M_stays = stays | (mistake == "M stays")
    return {"W": np.where(stays, W, 0), "M": np.where(M_stays, M, 0)}


def boiling(real, mistake, radiance, W, M, width, strength):
    """Summed one after the other, from the last pixel, in the backend's own type."""
    light = dots(radiance, WEIGHTS.astype(real)) * W
    if mistake == "without W":
        light = dots(radiance, WEIGHTS.astype(real)) * (W > 0)
    size = 8 if mistake == "tiles of 8" else 16
    y, x = np.divmod(np.arange(len(W)), width)
    if mistake == "tiles from below":
        y = y.max() - y
    tile = y // size * width + x // size
    total = np.zeros(tile.max() + 1, real)
    np.add.at(total, tile[::-1], light[::-1])
    counts = (light > 0) | (mistake == "dark pixels count")
    count = np.bincount(tile, counts).astype(real)
    mean = (total / np.maximum(count, 1))[tile]
    less = {"a limit too high": 8, "a limit too low": 10}.get(mistake, 9)
    limit = real(10) / real(strength) - less
    stays = light <= mean * limit
    M_stays = stays | (mistake == "M stays")
    return {"W": np.where(stays, W, 0), "M": np.where(M_stays, M, 0)}


def checkerboard(real, mistake, pixel, has_history, width, frame):
    """Parities by their lowest bits."""
    places = [pixel % width, pixel // width, frame]
    if mistake == "other colour":
        places.append(1)
    if mistake == "time stands still":
        places = places[:2]
    if mistake == "parity of the pixel":
        places = [pixel, frame]
    turn = np.bitwise_xor.reduce(
        [np.asarray(p) & 1 for p in np.broadcast_arrays(*places)]
    )
    anew = turn == 0
    if mistake != "history does not matter":
        anew |= has_history == 0
    return {"draws": anew}


def roulette(real, mistake, pixel, width, frame, seed, probability):
    """A probability in the backend's own type."""
    across = width // 64 if mistake == "tiles cut off" else -(-width // 64)
    tall = 64 if mistake == "square tiles" else 32
    y, x = np.divmod(pixel, width)
    tile = pixel if mistake == "pixel by pixel" else y // tall * across + x // 64
    stream = 6 if mistake == "stream of the path" else 7
    key = [np.full(len(pixel), v, np.uint32) for v in (frame, seed, 64 * stream)]
    words = pcg4d(tile.astype(np.uint32), *key)
    u = to_unit_interval(words[1 if mistake == "lane 1" else 0])
    p = real(probability)
    lives = u <= p if mistake == "equal goes on" else u < p
    weight = 1 if mistake == "not divided" else 1 / p
    return {"weight": np.where(lives, weight, 0)}


OTHERS = {
    "gbuffer": gbuffer,
    "reproject": reproject,
    "validation": validation,
    "boiling": boiling,
    "checkerboard": checkerboard,
    "roulette": roulette,
    "pack": pack,
    "unpack": unpack,
}

PLANTED = {
    "gbuffer": "up as it is; corner of the pixel; y counts upwards; behind;"
    " angle of the height; back faces are not met; parallelogram; normal of the front;"
    " distance; misses keep their numbers",
    "reproject": "up as it is; behind; half a pixel; y counts upwards; rounds;"
    " truncates; clamped to the image; distance; relative to its own; one side;"
    " normals are not compared; misses go on",
    "validation": "only what darkens; only what brightens; relative to then;"
    " relative to now; strict; no ray; nulls are asked; M stays",
    "boiling": "without W; tiles of 8; tiles from below; dark pixels count;"
    " a limit too high; a limit too low; M stays",
    "checkerboard": "other colour; time stands still; parity of the pixel;"
    " history does not matter",
    "roulette": "tiles cut off; square tiles; pixel by pixel; stream of the path;"
    " lane 1; equal goes on; not divided",
    "pack": "sign of 0 is 0; not divided; not folded; normals truncated; v first;"
    " sign extended; infinite halves; halves truncated; small halves are 0; by 32768;"
    " M wraps around; M below 1; red above; M below blue",
    "unpack": "not folded; not sign extended; −32768 as it is; by 32768;"
    " not normalized; NaN goes on; small halves are 0; normals exchanged; blue first;"
    " M has a sign",
}
MISTAKES = [(n, mistake) for n, text in PLANTED.items() for mistake in text.split("; ")]


def other(precision, name, mistake):
    """The other backend, perhaps with a mistake."""
    real = {"float32": np.float32, "float64": np.float64}[precision]
    return lambda **arguments: OTHERS[name](real, mistake, **arguments)


# ------------------------------------------------ tests


@both_precisions
@every_pass
def test_the_production_code_passes(precision, name):
    def backend(**arguments):
        return FURTHER[name](precision, **arguments)

    found = judgements(precision, name, backend)
    assert found
    assert all(j is not None and j.passed for j in found)


@both_precisions
@every_pass
def test_another_order_of_operations_passes(precision, name):
    found = judgements(precision, name, other(precision, name, None))
    faults = [
        (case.name, c.name, int(np.argmax(c.excess)), float(c.excess.max()))
        for case, j in zip(cases(precision, name), found, strict=True)
        if j is not None
        for c in j.compared
        if (c.excess > 1).any()
    ]
    assert None not in found
    assert faults == []
    assert all(j.passed for j in found)


@both_precisions
@pytest.mark.parametrize(("name", "mistake"), MISTAKES)
def test_a_planted_mistake_is_found(precision, name, mistake):
    found = judgements(precision, name, other(precision, name, mistake))
    assert not all(j is not None and j.passed for j in found)


@every_pass
def test_the_cases_have_what_the_contract_asks_for(name):
    for precision in ("float32", "float64"):
        for case in cases(precision, name):
            wanted = pass_of(PASSES, case)
            required = [s.name for s in wanted.settings if not s.default]
            assert list(case.settings) == required
            assert set(case.inputs) == {f.name for f in wanted.inputs}
            assert re.fullmatch(r"[a-z0-9-]+", case.name)
            for field in wanted.inputs:
                array = case.inputs[field.name]
                assert array.shape == (case.rows, *field.columns)
                assert array.dtype == dtype_of(field.kind, precision)


def test_the_cases_are_always_the_same():
    for one, two in zip(
        further_cases("float32"), further_cases("float32"), strict=True
    ):
        assert one.settings == two.settings
        for name, array in one.inputs.items():
            assert array.tobytes() == two.inputs[name].tobytes()


def test_few_decisions_are_open_among_ordinary_rows():
    for name in ("gbuffer", "reproject", "validation", "boiling", "roulette"):
        first = judgements("float32", name, other("float32", name, None))[0]
        assert first.decisions.expected <= 0.01 * len(first.wrong)


def test_a_word_that_is_no_flag_is_refused():
    def backend(**arguments):
        out = gbuffer(np.float32, None, **arguments)
        return out | {"hit": out["hit"] * np.uint32(2)}

    assert not all(j.passed for j in judgements("float32", "gbuffer", backend))


def test_the_pass_is_what_the_renderer_does_on_a_real_scene():
    world = build_world(validate(find_scene("cornell-box")))
    camera = world.camera
    x, y = (v[::97] for v in pixel_centers(camera.width, camera.height))
    seen = visible_points(world, x, y)
    on_triangle = seen.surface.primitive < world.geometry.triangles
    rows = np.flatnonzero(seen.surface.hit & on_triangle)
    corners = world.geometry.triangle[seen.surface.primitive[rows], :3]
    settings = {
        f"{name}_{axis}": value
        for name in ("position", "target", "up")
        for axis, value in zip("xyz", getattr(camera, name), strict=True)
    }
    settings = {name.replace("position", "eye"): v for name, v in settings.items()}
    found = FURTHER["gbuffer"](
        "float64",
        (np.floor(y) * camera.width + np.floor(x)).astype(np.int32)[rows],
        corners[:, 0],
        corners[:, 0] + corners[:, 1],
        corners[:, 0] + corners[:, 2],
        **settings,
        fov_x=camera.fov,
        width=camera.width,
        height=camera.height,
    )
    # Embree looks at float32, and hits are kept inside of their triangles.
    near = world.geometry.extent * 2.0**-15
    hit = found["hit"] == 1
    assert hit.mean() > 0.99
    there = contact(world.geometry, seen.surface)[rows]
    assert abs(found["position"] - there)[hit].max() < near
    assert abs(found["depth"] - seen.depth[rows])[hit].max() < near
    assert abs(found["normal"] - seen.surface.normal[rows])[hit].max() < 1e-12


# ------------------------------------------------ diagnosis

KNOWN = {h.name: h for h in FURTHER_MISTAKES}
PAIRS = [
    (h, name)
    for h in FURTHER_MISTAKES
    for name in h.passes
    if h not in LAYOUT_MISTAKES  # which show where they are declared
]

THE_SAME = {
    "gbuffer": {
        "up as it is": "up-as-it-is",
        "corner of the pixel": "pixel-corner",
        "y counts upwards": "image-upside-down",
        "behind": "behind-the-camera",
        "angle of the height": "angle-of-the-height",
        "back faces are not met": "back-faces-not-met",
        "normal of the front": "normal-not-turned",
        "distance": "distance-for-depth",
    },
    "reproject": {
        "up as it is": "up-as-it-is",
        "behind": "behind-the-camera",
        "half a pixel": "place-half-a-pixel-aside",
        "y counts upwards": "image-upside-down",
        "rounds": "place-rounded",
        "truncates": "place-truncated",
        "clamped to the image": "place-clamped",
        "distance": "distance-for-depth",
        "relative to its own": "place-depth-relative-to-own",
        "normals are not compared": "normals-not-tested",
        "misses go on": "misses-go-on",
    },
    "validation": {
        "only what darkens": "validation-of-darker-alone",
        "only what brightens": "validation-of-brighter-alone",
        "relative to then": "validation-relative-to-then",
        "relative to now": "validation-relative-to-now",
        "no ray": "validation-without-ray",
        "nulls are asked": "validation-asks-nulls",
        "M stays": "validation-keeps-m",
    },
    "boiling": {
        "tiles of 8": "boiling-tiles-of-8",
        "dark pixels count": "boiling-mean-over-all",
        "M stays": "boiling-keeps-m",
    },
    "checkerboard": {
        "other colour": "checkerboard-other-half",
        "time stands still": "checkerboard-stands-still",
        "parity of the pixel": "checkerboard-of-pixel-numbers",
        "history does not matter": "checkerboard-without-history",
    },
    "roulette": {
        "tiles cut off": "roulette-tiles-rounded-down",
        "pixel by pixel": "roulette-by-pixels",
        "not divided": "roulette-not-divided",
    },
    "pack": {
        "sign of 0 is 0": "sign-of-0-is-0",
        "not divided": "octahedron-not-divided",
        "not folded": "octahedron-not-folded",
        "normals truncated": "pack-normals-toward-0",
        "v first": "v-before-u",
        "sign extended": "pack-sign-runs-over",
        "infinite halves": "pack-halves-overflow",
        "halves truncated": "pack-halves-toward-0",
        "small halves are 0": "small-halves-are-0",
        "by 32768": "octahedron-by-32768",
        "M wraps around": "pack-m-wraps",
        "M below 1": "pack-m-becomes-0",
        "M below blue": "m-before-blue",
    },
    "unpack": {
        "not folded": "octahedron-not-folded",
        "by 32768": "octahedron-by-32768",
        "not normalized": "unpack-not-normalized",
        "small halves are 0": "small-halves-are-0",
        "normals exchanged": "normals-exchanged",
        "blue first": "blue-first",
        "M has a sign": "unpack-m-with-sign",
    },
}
"""Mistakes of the other backend, and what they are called."""

NAMED = [(n, m, called) for n, of in THE_SAME.items() for m, called in of.items()]


def diagnosed(precision, name, backend):
    """Whether anything is wrong, and what explains it."""
    answers = []
    for case in cases(precision, name):
        with np.errstate(all="ignore"):
            raw = backend(case)
        outputs = pass_of(PASSES, case).outputs
        fields = {f.name: dtype_of(f.kind, precision) for f in outputs}
        out = {n: np.ascontiguousarray(raw[n], dtype) for n, dtype in fields.items()}
        answers.append(examined(PASSES, precision, replayed("L0", case), out))
    shows = not all(answer.finding.passed for answer in answers)
    return shows, [h.name for h in diagnose(name, answers, precision).matches]


def right(precision, case):
    """The answer of the production code."""
    out = FURTHER[case.pass_name](precision, **case.inputs, **case.settings)
    return dict(out)


def under(hypothesis):
    """The answers of a backend that makes a mistake: what its own replay expects."""

    def answer(case):
        out = right("float32", case)
        if case.pass_name == "pack":
            return {"words": wrong_words(hypothesis, out["words"], case)}
        judge = FURTHER_JUDGES[case.pass_name]
        judgement = judge(case, out, hypothesis.rules, "float32")
        most = float(np.finfo(np.float32).max)
        for one in judgement.compared:
            wanted = np.clip(one.expected, -most, np.maximum(most, one.expected))
            out[one.name] = wanted.astype(out[one.name].dtype)
        return out

    return answer


def wrong_words(hypothesis, words, case):
    """In another layout, or by the other backend."""
    halves = list(hypothesis.rules.part.halves)
    if halves != list(range(24)):
        found = np.empty((len(words), 24), "<u2")
        found[:, halves] = np.ascontiguousarray(words).view("<u2")
        return found.view("<u4")
    same = {called: mistake for mistake, called in THE_SAME["pack"].items()}
    return pack(np.float32, same[hypothesis.name], **case.inputs)["words"]


@pytest.mark.parametrize(
    ("hypothesis", "name"), PAIRS, ids=[f"{h.name}-{name}" for h, name in PAIRS]
)
def test_a_known_mistake_shows_and_is_called_by_its_name(hypothesis, name):
    shows, names = diagnosed("float32", name, under(hypothesis))
    assert shows
    assert names == [hypothesis.name]


@both_precisions
@pytest.mark.parametrize(("name", "mistake", "called"), NAMED)
def test_a_mistake_of_the_other_backend_is_called_by_its_name(
    precision, name, mistake, called
):
    other_backend = other(precision, name, mistake)
    shows, names = diagnosed(
        precision, name, lambda case: other_backend(**case.inputs, **case.settings)
    )
    assert shows
    assert names == [called]


UNKNOWN = [pair for pair in MISTAKES if pair not in {(n, m) for n, m, _ in NAMED}]


@pytest.mark.parametrize(("name", "mistake"), UNKNOWN)
def test_a_mistake_that_nobody_knows_has_no_name(name, mistake):
    backend = other("float32", name, mistake)
    _, names = diagnosed(
        "float32", name, lambda case: backend(**case.inputs, **case.settings)
    )
    assert names == []


@every_pass
def test_what_is_right_has_no_name(name):
    assert diagnosed("float32", name, lambda case: right("float32", case)) == (
        False,
        [],
    )


def test_no_two_mistakes_share_a_name():
    names = [h.name for h in (*HYPOTHESES, *FURTHER_MISTAKES)]
    assert len(set(names)) == len(names)
