"""Method ``area-restir``: on the command line, and the same bits however it is cut."""

from itertools import islice

import numpy as np
import pytest

from restir_gi.extensions.area_method import METHOD
from restir_gi.extensions.area_restir import render_area_frames
from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.methods.discovery import method_named, method_names
from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.system.errors import UsageError
from tests.properties.path_scenes import world


def last(schedule, settings, name="glass", frames=3, animation=None):
    found = render_area_frames(world(name), settings, 2, 5, schedule, animation)
    return list(islice(found, frames))[-1]


def a_moving_camera():
    return find_animation("moving-camera", world("moving-camera").scene)


@pytest.mark.parametrize("primary", ["move", "keep"])
def test_bands_and_threads_change_no_bit(primary):
    settings, path = AreaSettings(primary=primary), a_moving_camera()
    whole, cut = (
        last(schedule, settings, "moving-camera", animation=path)
        for schedule in (Schedule(1 << 20), Schedule(100, 2))
    )
    np.testing.assert_array_equal(whole.color, cut.color)
    np.testing.assert_array_equal(whole.reservoirs.M, cut.reservoirs.M)
    assert np.isfinite(whole.color).all()
    assert whole.color.any()


@pytest.mark.parametrize("primary", ["move", "keep"])
def test_paths_appear_in_the_pixels_that_keep_them(primary):
    settings, path = AreaSettings(primary=primary), a_moving_camera()
    r = last(Schedule(), settings, "moving-camera", 4, path).reservoirs
    row = np.arange(len(r.W))
    full = r.W > 0
    assert full.mean() > 0.9
    np.testing.assert_array_equal(np.floor(r.y.x)[full], (row % 32)[full])
    np.testing.assert_array_equal(np.floor(r.y.y)[full], (row // 32)[full])


def test_confidence_grows_to_its_cap_and_looks_at_no_sample():
    settings = AreaSettings(temporal_cap=4, spatial=False)
    assert set(last(Schedule(), settings, frames=6).reservoirs.M) == {4.0}


def test_confidence_of_a_moving_pixel_is_a_mean_of_its_windows():
    """Not their sum: what was there a frame ago is one pixel's area."""
    settings = AreaSettings(temporal_cap=100, spatial=False)
    frame = last(Schedule(), settings, "moving-camera", 5, a_moving_camera())
    assert frame.reservoirs.M.max() <= 5.0 * (1 + 1e-12)
    assert np.median(frame.reservoirs.M) > 4


def test_weights_that_count_other_areas_are_refused():
    with pytest.raises(UsageError, match="mis"):
        with_values(METHOD.settings, ["mis=1/M"])


def test_it_is_found_by_name():
    assert "area-restir" in method_names()
    assert method_named("area-restir") is METHOD


def test_it_renders_from_the_command_line_with_its_layers(tmp_path):
    out = tmp_path / "picture.exr"
    text = (
        "render cornell-box --method area-restir --frames 2 --spp 1 --bounces 2"
        " --size 24x16 --set primary=keep --set shift=hybrid --aov x,y,M,direct"
    )
    assert main([*text.split(), "--out", str(out)]) == 0
    found = read_exr(out)
    column = np.floor(found.layers["x"][..., 0])
    seen = found.layers["M"][..., 0] > 0
    assert seen.any()
    # A pixel without any path keeps a place as well.
    np.testing.assert_array_equal(column, np.tile(np.arange(24), (16, 1)))
    assert found.layers["direct"].any()
