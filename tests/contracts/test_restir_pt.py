"""Method ``restir-pt``: on the command line, and the same bits however it is cut."""

from itertools import islice

import numpy as np
import pytest

from restir_gi.extensions.method import METHOD
from restir_gi.extensions.pt_settings import PathSettings
from restir_gi.extensions.restir_pt import render_path_frames
from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.methods.discovery import method_named, method_names
from restir_gi.reference.methods.method import Job
from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.system.errors import UsageError
from tests.properties.path_scenes import world


def last(schedule, settings, name="glass", frames=3):
    found = render_path_frames(world(name), settings, 3, 5, schedule)
    return list(islice(found, frames))[-1]


@pytest.mark.parametrize("mis", ["1/M", "1/Z", "balance", "pairwise", "defensive"])
def test_bands_and_threads_change_no_bit(mis):
    settings = PathSettings(mis=mis)
    whole = last(Schedule(1 << 20), settings)
    cut = last(Schedule(100, 2), settings)
    np.testing.assert_array_equal(whole.color, cut.color)
    np.testing.assert_array_equal(whole.reservoirs.M, cut.reservoirs.M)
    assert np.isfinite(whole.color).all()
    assert whole.color.any()


def test_it_is_found_by_name():
    assert "restir-pt" in method_names()
    assert method_named("restir-pt") is METHOD


def test_confidence_grows_to_its_cap_and_looks_at_no_sample():
    settings = PathSettings(temporal_cap=4, spatial=False)
    assert set(last(Schedule(), settings, frames=6).reservoirs.M) == {4.0}


def test_without_reuse_every_frame_begins_anew():
    settings = PathSettings(temporal=False, spatial=False)
    assert set(last(Schedule(), settings).reservoirs.M) == {1.0}


@pytest.mark.parametrize(
    "text", ["neighbors=64", "temporal_cap=0", "radius=2", "mis=median", "shift=none"]
)
def test_settings_out_of_range_are_refused(text):
    with pytest.raises(UsageError, match=text.partition("=")[0]):
        with_values(METHOD.settings, [text])


def job(**changes):
    given = {
        "world": world("paint"),
        "light": "indirect",
        "bounces": 2,
        "seed": 0,
        "counts": {"frames": 1, "spp": 1},
        "settings": METHOD.settings,
        "aovs": (),
        "schedule": Schedule(),
    }
    return Job(**(given | changes))


def test_it_says_what_biases_it():
    assert METHOD.biases(job()) == ()
    biased = PathSettings(mis="1/M")
    assert "1/M" in METHOD.biases(job(settings=biased))[0]
    assert METHOD.biases(job(settings=biased, light="direct")) == ()


def test_layers_say_where_paths_are_joined(tmp_path):
    out = tmp_path / "x.exr"
    words = "render cornell-box --method restir-pt --frames 2 --size 24x16 --bounces 3"
    aovs = ["--aov", "joint,length,M,depth", "--out", str(out)]
    assert main([*words.split(), *aovs]) == 0
    layers = read_exr(out).layers
    joint, length = layers["joint"], layers["length"]
    assert set(np.unique(joint)) <= {0, 2, 3, 4}
    assert (length >= joint).all()
    assert layers["M"].max() > 1
