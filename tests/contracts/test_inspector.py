"""What the inspector shows: the buffers of the run, and what made them."""

import json
from collections import deque
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr, write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.methods import Job, method_named
from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.inspector.candidates import NOT_ASKED
from restir_gi.reference.reports.inspector.outcomes import Outcome
from restir_gi.reference.reports.inspector.page import MOST, packed, page
from restir_gi.reference.reports.inspector.recorded import plain_frame
from restir_gi.reference.reports.inspector.recorder import recorded_frames
from restir_gi.reference.reports.inspector.wireframe import MOST_EDGES, edges
from restir_gi.reference.scene.catalogue.registry import find_animation, find_scene
from restir_gi.reference.transport.world import build_world

ROUNDING = 16 * np.finfo(float).eps
"""A sum of at most 11 terms in two orders, and three products: ½ ulp each."""

SETTINGS = {
    "unbiased": ("restir-gi-unbiased", ()),
    "biased": ("restir-gi-biased", ()),
    "balance": ("restir-gi-unbiased", ("mis=balance",)),
    "pairwise": ("restir-gi-unbiased", ("mis=pairwise",)),
    "chosen": ("restir-gi-unbiased", ("visibility=chosen",)),
    "fused": ("restir-gi-unbiased", ("reuse=fused",)),
    "double-buffered": ("restir-gi-unbiased", ("reuse=double-buffered",)),
    "boosted": ("restir-gi-unbiased", ("boost_below=40",)),
    "limited": ("restir-gi-unbiased", ("jacobian_limit=1.5",)),
    "temporal": ("restir-gi-unbiased", ("spatial=false",)),
    "permuted": ("restir-gi-unbiased", ("permutation=true", "mis=balance")),
    "lattice": ("restir-gi-unbiased", ("lattice=2",)),
}


def job(scene, method, values, side=16, frames=4):
    found = find_scene(scene)
    found = replace(found, camera=replace(found.camera, width=side, height=side))
    method = method_named(method)
    return Job(
        world=build_world(found),
        light="indirect",
        bounces=1,
        seed=7,
        counts={"frames": frames, "spp": 1},
        settings=with_values(method.settings, values),
        aovs=(),
        schedule=Schedule(),
        animation=find_animation(scene, found),
    )


def watched(scene, name, frames=4):
    return list(islice(recorded_frames(job(scene, *SETTINGS[name])), frames))


@pytest.mark.parametrize("scene", ["cornell-box", "moving-block"])
@pytest.mark.parametrize("name", SETTINGS)
def test_what_is_shown_makes_what_is_kept(scene, name):
    """W = Σ w / (p̂ total), of the sample that stands in the place that was kept."""
    for shown in watched(scene, name):
        for made_by, r in zip(shown.passes, reservoirs(shown), strict=True):
            rows, full = np.arange(len(r.W)), r.W > 0
            at = (rows[full], made_by.kept[full])
            assert full.any()
            np.testing.assert_array_equal(made_by.position[at], r.y.position[full])
            assert (made_by.outcome[at] == Outcome.COMPETED).all()
            total = made_by.total[full] * made_by.p_hat[at]
            W = made_by.w.sum(axis=1)[full] / total
            np.testing.assert_allclose(W, r.W[full], rtol=ROUNDING)
            np.testing.assert_allclose(made_by.w_sum[full] / total, W, rtol=ROUNDING)


def reservoirs(shown):
    both = (shown.frame.temporal, shown.frame.spatial)
    return both[: len(shown.passes)]


@pytest.mark.parametrize("name", ["unbiased", "biased", "fused", "boosted", "limited"])
def test_weights_follow_from_their_factors(name):
    """The weight w = p̂ W M J of those that competed, and 0 of all others."""
    run = watched("cornell-box", name)
    for made_by in (one for shown in run for one in shown.passes):
        competed = made_by.outcome == Outcome.COMPETED
        w = made_by.p_hat * made_by.W * made_by.M * made_by.jacobian
        # Products of four factors in another order.
        np.testing.assert_allclose(made_by.w[competed], w[competed], rtol=ROUNDING)
        assert not made_by.w[~competed].any()


@pytest.mark.parametrize("name", ["unbiased", "double-buffered"])
def test_z_is_the_sum_over_those_who_could(name):
    for shown in watched("moving-block", name):
        made_by = shown.passes[1]
        kept = made_by.w_sum > 0
        Z = np.sum(made_by.M * (made_by.could != 0), axis=1)
        np.testing.assert_array_equal(Z[kept], made_by.total[kept])
    assert (made_by.could == 0).any()


def test_who_is_not_asked_is_not_said_to_answer():
    made_by = watched("cornell-box", "biased")[-1].passes[1]
    tried = made_by.outcome != Outcome.UNTRIED
    assert (made_by.could[tried] == NOT_ASKED).all()


@pytest.mark.parametrize("name", ["unbiased", "limited", "fused"])
def test_reasons_are_true(name):
    """Each reason asked of the scene, not of the weights."""
    counted = np.zeros(len(Outcome), int)
    for shown in watched("moving-block", name):
        world, points = shown.frame.world, shown.frame.visible.surface
        for made_by in shown.passes:
            counted += np.bincount(made_by.outcome.ravel(), minlength=len(Outcome))
            for place, role in enumerate(made_by.roles):
                outcome, J = made_by.outcome[:, place], made_by.jacobian[:, place]
                absent = np.isin(outcome, (Outcome.ABSENT, Outcome.UNTRIED))
                np.testing.assert_array_equal(made_by.M[:, place] <= 0, absent)
                assert (made_by.p_hat[outcome == Outcome.DARK, place] == 0).all()
                beyond = np.maximum(J, 1 / np.where(J > 0, J, 1)) > 1.5
                refused = outcome == Outcome.REFUSED
                assert (beyond[refused] & (J[refused] > 0)).all()
                if name == "limited":
                    assert not beyond[outcome == Outcome.COMPETED].any()
                if role != "neighbour":
                    continue
                x = made_by.position[:, place]
                open_to = unobstructed(world, points.position, x)
                assert open_to[outcome == Outcome.COMPETED].all()
                assert not open_to[outcome == Outcome.HIDDEN].any()
    told = {
        Outcome.ABSENT,
        Outcome.EMPTY,
        Outcome.DARK,
        Outcome.HIDDEN,
        Outcome.COMPETED,
    }
    told |= {Outcome.REFUSED} if name == "limited" else set()
    assert all(counted[list(told)] > 0)


def unobstructed(world, x_from, x_to):
    """Möller and Trumbore, of every segment with every triangle: no ray caster."""
    a, to_b, to_c = (world.geometry.triangle[None, :, k] for k in range(3))
    along = (x_to - x_from)[:, None]
    p = np.cross(along, to_c)
    det = np.sum(p * to_b, axis=2)
    with np.errstate(all="ignore"):
        off = x_from[:, None] - a
        u = np.sum(off * p, axis=2) / det
        q = np.cross(off, to_b)
        v = np.sum(along * q, axis=2) / det
        t = np.sum(to_c * q, axis=2) / det
    # Ends lie on surfaces: what is met within a millionth of the way is the end's own.
    met = (u > 0) & (v > 0) & (u + v < 1) & (t > 1e-6) & (t < 1 - 1e-6)
    return ~met.any(axis=1)


@pytest.mark.parametrize("name", ["unbiased", "fused", "double-buffered", "boosted"])
def test_origins_are_those_of_the_sample(name):
    """The path that a reservoir names did draw its sample, at that pixel and frame."""
    run = watched("cornell-box", name)
    for shown in run:
        for made_by, r in zip(shown.passes, reservoirs(shown), strict=True):
            full = r.W > 0
            frame, pixel = np.divmod(made_by.number[full], len(full))
            assert (made_by.number[~full] == -1).all()
            drawn = [
                one.passes[0].position[:, one.passes[0].roles.index("new sample")]
                for one in run
            ]
            np.testing.assert_array_equal(
                np.stack(drawn)[frame, pixel], r.y.position[full]
            )
    assert len(set(frame.tolist())) > 1
    assert (pixel != np.flatnonzero(full)).any()


def test_a_sample_names_its_pixel_and_not_the_next_one():
    """Control of the test above: origins that are off by a pixel are found out."""
    last = watched("cornell-box", "unbiased")[-1]
    made_by, r = last.passes[0], last.frame.temporal
    new = (made_by.number // len(r.W) == last.frame.number) & (r.W > 0)
    drawn = made_by.position[:, made_by.roles.index("new sample")]
    shifted = np.roll(drawn, 1, axis=0)
    assert not np.array_equal(shifted[new], r.y.position[new])


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for name in ("unbiased", "biased"):
        aovs = "M,W,radiance,sample_position,sample_normal,mean,direct"
        assert render(folder / f"{name}.exr", f"restir-gi-{name}", "--aov", aovs) == 0
    return folder


def render(out, method, *more):
    size = ("--size", "16x12", "--frames", "3", "--spp", "2", "--seed", "5")
    return main(
        ["render", "cornell-box", "--method", method, *size, *more, "--out", str(out)]
    )


def inspect(capsys, *arguments):
    code = main(["inspect", *map(str, arguments), "--json"])
    heard = capsys.readouterr()
    return code, json.loads(heard.out) if code == 0 else heard.err


def test_a_run_is_made_again_bit_for_bit(pictures, capsys, tmp_path):
    out = tmp_path / "page.html"
    names = [pictures / f"{name}.exr" for name in ("unbiased", "biased")]
    code, told = inspect(capsys, *names, "--out", out)
    assert code == 0
    for one in told["runs"]:
        assert one["frames"] == [0, 1, 2]
        assert one["standing"].endswith("every layer is that of the file, bit for bit.")
    text = out.read_text()
    assert "http" not in text.replace("http-equiv", "")


def test_a_file_that_is_not_of_its_header_is_told(pictures, capsys, tmp_path):
    image = read_exr(pictures / "unbiased.exr")
    layers = dict(image.layers)
    layers["W"] = layers["W"].copy()
    layers["W"][3, 4] *= 2
    write_exr(tmp_path / "other.exr", Image(layers, image.metadata))
    out = tmp_path / "page.html"
    code, told = inspect(capsys, tmp_path / "other.exr", "--out", out)
    assert code == 0
    assert "1 of 192 pixels are not those of the file" in told["runs"][0]["standing"]


def test_a_picture_of_another_renderer_is_shown_as_it_is(pictures, capsys, tmp_path):
    image = read_exr(pictures / "biased.exr")
    write_exr(tmp_path / "theirs.exr", Image(image.layers, {}))
    out = tmp_path / "page.html"
    code, told = inspect(
        capsys, pictures / "unbiased.exr", tmp_path / "theirs.exr", "--out", out
    )
    assert code == 0
    assert [one["replayed"] for one in told["runs"]] == [True, False]
    assert [one["frames"] for one in told["runs"]] == [[0, 1, 2], [None]]


def test_only_the_last_frames_are_kept(pictures, capsys, tmp_path):
    out = tmp_path / "page.html"
    code, told = inspect(capsys, pictures / "biased.exr", "--last", 2, "--out", out)
    assert code == 0
    assert told["runs"][0]["frames"] == [1, 2]


def test_a_scene_that_moves_is_made_again(capsys, tmp_path):
    out = tmp_path / "moving.exr"
    method, frames = ("--method", "restir-gi-unbiased"), ("--frames", "3")
    where = ("--size", "12x12", "--frame", "2", "--out", str(out))
    assert main(["render", "moving-block", *method, *frames, *where]) == 0
    capsys.readouterr()
    code, told = inspect(capsys, out, "--out", tmp_path / "page.html")
    assert code == 0
    assert "bit for bit" in told["runs"][0]["standing"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": None}, "the header lacks 'seed'"),
        ({"settings.mis": "best"}, "not understood by this version"),
        ({"frames": "many"}, "not understood by this version"),
        ({"frames": "0"}, "frames=0 is out of range"),
        ({"bounces": "31"}, "bounces=31 is out of range"),
        ({"light": "dim"}, "not understood by this version"),
        ({"scene": "my-room"}, "name its file with --scene"),
        ({"bounces": "0"}, "no frames of indirect light"),
    ],
)
def test_a_header_that_does_not_do_is_refused(
    pictures, capsys, tmp_path, change, message
):
    image = read_exr(pictures / "unbiased.exr")
    words = {**image.metadata, **change}
    words = {key: text for key, text in words.items() if text is not None}
    write_exr(tmp_path / "odd.exr", Image({"color": image.color}, words))
    out = tmp_path / "page.html"
    code, heard = inspect(capsys, tmp_path / "odd.exr", "--out", out)
    assert code == 2
    assert message in heard
    assert len(heard.splitlines()) == 1
    assert not out.exists()


def test_a_scene_from_a_file_is_named_again(capsys, tmp_path):
    scene, out = tmp_path / "tent.obj", tmp_path / "tent.exr"
    scene.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n")
    how = ("--method", "restir-gi-biased", "--size", "8x8", "--frames", "2")
    assert main(["render", str(scene), *how, "--lenient", "--out", str(out)]) == 0
    capsys.readouterr()
    page = ("--out", tmp_path / "page.html")
    code, heard = inspect(capsys, out, *page)
    assert code == 2
    assert "name its file with --scene" in heard
    code, told = inspect(capsys, out, "--scene", scene, "--lenient", *page)
    assert code == 0
    assert "bit for bit" in told["runs"][0]["standing"]
    code, heard = inspect(capsys, out, "--scene", "cornell-box", *page)
    assert code == 2
    assert "rendered from 'tent', not from 'cornell-box'" in heard


def test_pictures_of_two_sizes_are_refused(pictures, capsys, tmp_path):
    size = ("--size", "8x8")
    assert render(tmp_path / "small.exr", "restir-gi-biased", *size) == 0
    capsys.readouterr()
    two, out = (pictures / "biased.exr", tmp_path / "small.exr"), tmp_path / "x.html"
    code, heard = inspect(capsys, *two, "--out", out)
    assert code == 2
    assert "16x12" in heard
    assert "8x8" in heard


def test_a_page_that_no_browser_could_hold_is_refused():
    frame = {"color": np.zeros(MOST // 4 + 1, np.float32)}
    run = {"label": "", "name": "", "words": {}, "standing": "", "replayed": False}
    with pytest.raises(Exception, match="keep fewer frames with --last"):
        page("x", [run | {"width": 1, "height": 1, "frames": [frame]}], 1.0)


def test_words_of_a_header_stay_words():
    evil = "</script><script>alert(1)</script>"
    run = {"label": "", "name": evil, "words": {evil: evil}, "standing": evil}
    run |= {"replayed": False, "width": 1, "height": 1, "frames": [{"name": evil}]}
    text = page(evil, [run], 1.0).decode()
    assert "<script>alert" not in text


def test_what_is_packed_is_found_again():
    a, b = np.arange(5, dtype=np.float32), np.arange(3, dtype=np.uint8)
    structure, block = packed({"list": [a, b, a], "word": "w", "none": None})
    places = structure["list"]
    assert places[0] == places[2]
    for place, array in zip(places, (a, b, a), strict=True):
        found = np.frombuffer(
            block, place["kind"], place["length"], offset=place["offset"]
        )
        np.testing.assert_array_equal(found, array)
        assert place["offset"] % 8 == 0


def test_numbers_of_the_page_are_those_of_the_buffers():
    last = deque(recorded_frames_of_four(), maxlen=1)[0]
    plain = plain_frame(last)
    temporal, spatial = plain["reservoirs"]
    for shown, r in ((temporal, last.frame.temporal), (spatial, last.frame.spatial)):
        for name, values in (("M", r.M), ("W", r.W), ("position", r.y.position)):
            np.testing.assert_array_equal(shown[name], values.astype(np.float32))


def recorded_frames_of_four():
    return islice(recorded_frames(job("cornell-box", *SETTINGS["unbiased"])), 4)


def test_each_edge_is_drawn_once():
    """A tetrahedron has four faces and six edges."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    faces = np.array([[0, 1, 2], [0, 2, 3], [3, 1, 0], [1, 3, 2]])
    a, b, c = (corners[faces[:, k]] for k in range(3))
    triangle = np.stack([a, b - a, c - a, np.zeros_like(a)], axis=1)
    geometry = build_world(find_scene("cornell-box")).geometry
    found = edges(replace(geometry, triangle=triangle))
    known = {frozenset(map(tuple, corners[[i, j]])) for i in range(4) for j in range(i)}
    assert len(found) == len(known) == 6
    assert {frozenset(map(tuple, edge.tolist())) for edge in found} == known


def test_spheres_have_no_edges():
    assert len(edges(build_world(find_scene("sphere-furnace")).geometry)) == 0


def test_a_fine_mesh_is_not_drawn():
    world = build_world(find_scene("cornell-box"))
    many = np.tile(world.geometry.triangle, (MOST_EDGES // 3, 1, 1))
    assert edges(replace(world.geometry, triangle=many)) is None
