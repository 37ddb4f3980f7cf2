"""Settings that go together, by one word: ``--preset``."""

from dataclasses import asdict

import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.methods.discovery import method_named, method_names
from restir_gi.reference.methods.method import preset_values
from restir_gi.reference.methods.setting_values import as_text, with_values
from restir_gi.reference.system.errors import UsageError

PRESETS = [
    (name, preset) for name in method_names() for preset in method_named(name).presets
]


def settings_of(name, preset, *assignments):
    method = method_named(name)
    return with_values(method.settings, (*preset_values(method, preset), *assignments))


@pytest.mark.parametrize(("name", "preset"), PRESETS)
def test_a_preset_changes_what_it_names_and_nothing_else(name, preset):
    method = method_named(name)
    named = {v.partition("=")[0] for v in method.presets[preset].values}
    assert len(named) == len(method.presets[preset].values)
    before, after = asdict(method.settings), asdict(settings_of(name, preset))
    changed = {key for key in before if before[key] != after[key]}
    assert changed
    assert changed <= named


def test_the_paper_has_equation_10_roulette_and_two_buffers():
    for name in ("restir-gi-biased", "restir-gi-unbiased"):
        s = settings_of(name, "paper")
        assert (s.target, s.roulette, s.reuse) == ("outgoing", 0.25, "double-buffered")
        assert (s.temporal_cap, s.spatial_cap) == (30, 500)
    assert settings_of("restir-gi-biased", "paper").mis == "1/M"


def test_what_is_set_by_hand_counts_more():
    assert settings_of("restir-gi-biased", "rtxdi", "max_age=9").max_age == 9


def rendered(tmp_path, *words):
    out = tmp_path / "x.exr"
    few = ["--size", "8x8", "--frames", "2", "--spp", "1", "--out", str(out)]
    assert main(["render", "cornell-box", *few, *words]) == 0
    return read_exr(out).metadata


@pytest.mark.parametrize("preset", ["paper", "rtxdi", "restir_pt"])
def test_the_header_says_what_was_set(tmp_path, preset):
    header = rendered(
        tmp_path, "--method", "restir-gi-unbiased", "--preset", preset, "--bounces", "2"
    )
    settings = as_text(settings_of("restir-gi-unbiased", preset))
    assert {k: header[f"settings.{k}"] for k in settings} == settings


def test_an_unknown_preset_is_answered_with_the_list(tmp_path, capsys):
    words = ["--method", "restir-gi-biased", "--preset", "papr"]
    out = ["--out", str(tmp_path / "x.exr")]
    assert main(["render", "cornell-box", *out, *words]) == 2
    told = capsys.readouterr().err
    assert "did you mean paper?" in told
    assert "paper, rtxdi, restir_pt" in told


def test_a_method_without_presets_says_so():
    with pytest.raises(UsageError, match="known are none"):
        preset_values(method_named("path"), "paper")
