"""The numbers of a comparison, against sums done by hand."""

import json
from dataclasses import fields

import numpy as np
import pytest

from restir_gi.reference.images.image import Image
from restir_gi.reference.reports.comparison import Comparison, compare
from restir_gi.reference.reports.comparison.labels import NUMBERS
from restir_gi.reference.system.errors import UsageError


def grey(value, height=4, width=6):
    return np.full((height, width, 3), value, np.float32)


def image(value, error=None, **metadata):
    layers = {"color": value}
    if error is not None:
        layers["standard_error"] = error
    return Image(layers, metadata)


def test_of_an_image_with_itself_nothing_differs():
    numbers = compare(image(grey(0.5)), image(grey(0.5)))
    for name in ("relative_bias", "mse", "rmse", "rel_mse", "mape", "smape"):
        assert getattr(numbers, name) == 0
    assert numbers.flip_ldr == numbers.flip_hdr == 0
    assert numbers.z_rms is numbers.mse_of_b is numbers.mse_corrected is None


def test_numbers_of_flat_images():
    """A is 3/2 of B = 0.5, whose standard error is 0.1."""
    numbers = compare(image(grey(0.75)), image(grey(0.5), grey(0.1)))
    assert (numbers.width, numbers.height) == (6, 4)
    assert numbers.mean_a == (0.75, 0.75, 0.75)
    assert numbers.exposure == pytest.approx(0.8 / 0.5)
    assert numbers.relative_bias == pytest.approx(0.5)
    assert numbers.mse == pytest.approx(0.0625)
    assert numbers.mse_of_b == pytest.approx(0.01)
    assert numbers.mse_corrected == pytest.approx(0.0525)
    assert numbers.rel_mse_corrected == pytest.approx(0.0525 / 0.26)
    assert numbers.z_rms == pytest.approx(2.5)
    assert numbers.z_above_3 == 0
    assert numbers.flip_ldr > 0.05


def test_both_standard_errors_add_in_squares():
    a, b = image(grey(0.75), grey(0.3)), image(grey(0.5), grey(0.4))
    assert compare(a, b).z_rms == pytest.approx(0.5)


def test_a_standard_error_of_a_alone_gives_scores_but_no_correction():
    numbers = compare(image(grey(0.75), grey(0.1)), image(grey(0.5)))
    assert numbers.z_rms == pytest.approx(2.5)
    assert numbers.mse_corrected is None


def test_a_standard_error_of_one_component_holds_for_all_channels():
    numbers = compare(image(grey(0.75)), image(grey(0.5), grey(0.1)[..., :1]))
    assert numbers.z_rms == pytest.approx(2.5)


def test_certain_pixels_count_among_the_scores_above_3_only():
    error = grey(0.1)
    error[0] = 0
    numbers = compare(image(grey(0.75)), image(grey(0.5), error))
    assert numbers.z_above_3 == pytest.approx(1 / 4)
    assert numbers.z_rms == pytest.approx(2.5)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("layer", ["color", "standard_error"])
def test_pixels_that_are_not_finite_are_counted_and_left_out(bad, layer):
    a, b = image(grey(0.75), grey(0.1)), image(grey(0.5), grey(0.1))
    a.layers[layer][1, 2, 0] = bad
    b.layers[layer][1, 2:4, 1] = bad
    numbers = compare(a, b)
    assert (numbers.not_finite_a, numbers.not_finite_b) == (1, 2)
    assert numbers.mse == pytest.approx(0.0625)
    assert numbers.relative_bias == pytest.approx(0.5)


def test_images_of_one_pixel():
    assert compare(image(grey(2, 1, 1)), image(grey(1, 1, 1))).mse == 1


def test_radiance_at_the_end_of_the_range():
    numbers = compare(image(grey(-3e38)), image(grey(3e38)))
    assert numbers.mse == pytest.approx(3.6e77)


def test_for_json_infinity_is_none():
    numbers = compare(image(grey(1)), image(grey(0))).as_dict()
    assert numbers["relative_bias"] is None
    assert set(numbers) == {field.name for field in fields(Comparison)}
    assert json.loads(json.dumps(numbers, allow_nan=False))["mse"] == 1


def test_every_number_has_a_label():
    shown = {"width", "height"} | {number.name for number in NUMBERS}
    assert shown == {field.name for field in fields(Comparison)}


def test_other_sizes_are_refused_with_both(tmp_path):
    with pytest.raises(UsageError, match=r"a\.exr has 6x4 .*b\.exr 4x6") as error:
        compare(
            image(grey(1)), image(grey(1, 6, 4)), tmp_path / "x", ("a.exr", "b.exr")
        )
    assert len(str(error.value).splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_without_a_finite_pixel_there_is_nothing_to_compare(tmp_path):
    with pytest.raises(UsageError, match="no pixel is finite in both A and B"):
        compare(image(grey(np.nan)), image(grey(1)), tmp_path / "x")
    assert not list(tmp_path.iterdir())
