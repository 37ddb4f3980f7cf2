"""OpenEXR files: ours hold every bit, and foreign ones are understood."""

import numpy as np
import OpenEXR
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from restir_gi.reference.images.exr import read_exr, write_exr
from restir_gi.reference.images.image import Image

SCAN = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
SPECIAL = np.array(
    [0.0, -0.0, -1.5, 1e-45, -1e-42, 3.4e38, np.inf, -np.inf, np.nan], np.float32
)

sizes = st.tuples(st.integers(1, 9), st.integers(1, 9))
any_bits = sizes.flatmap(
    lambda size: arrays(np.uint32, (*size, 3)).map(lambda bits: bits.view(np.float32))
)


def picture(height, width, components=3, seed=0):
    shape = (height, width, components)
    return np.random.default_rng(seed).normal(size=shape).astype(np.float32)


def assert_same_bits(a, b):
    assert a.shape == b.shape
    np.testing.assert_array_equal(a.view(np.uint32), b.view(np.uint32))


def save(path, channels, header=SCAN):
    """Write a foreign file: the library's own way, not ours."""
    OpenEXR.File(dict(header), channels).write(str(path))
    return path


# ---------------------------------------------------------------- our files


@given(any_bits)
def test_every_bit_pattern_survives_a_file(tmp_path_factory, color):
    path = tmp_path_factory.mktemp("exr") / "a.exr"
    write_exr(path, Image({"color": color}))
    assert_same_bits(read_exr(path).color, color)


@pytest.mark.parametrize("shape", [(1, 1), (1, 5000), (5000, 1), (3, 7)])
def test_special_values_survive_in_every_layer(tmp_path, shape):
    def special(components):
        return np.resize(SPECIAL, (*shape, components))

    layers = {"color": special(3), "standard_error": special(3), "depth": special(1)}
    write_exr(tmp_path / "a.exr", Image(layers))
    image = read_exr(tmp_path / "a.exr")
    assert image.layers.keys() == layers.keys()
    assert (image.height, image.width) == shape
    for name, layer in layers.items():
        assert_same_bits(image.layers[name], layer)


def test_a_strided_view_is_written_as_what_it_shows(tmp_path):
    """The library itself writes other numbers, and no error, for such arrays."""
    color = picture(8, 10)[::2, ::-1]
    write_exr(tmp_path / "a.exr", Image({"color": color}))
    assert_same_bits(read_exr(tmp_path / "a.exr").color, color.copy())


def test_metadata_survive(tmp_path):
    metadata = {"scene": "cornell-box", "empty": "", "note": "α ≤ 1\nsecond line"}
    write_exr(tmp_path / "a.exr", Image({"color": picture(2, 3)}, metadata))
    assert read_exr(tmp_path / "a.exr").metadata == metadata


def test_metadata_that_are_no_text_are_written_escaped(tmp_path):
    """A scene may lie in a folder whose name is not UTF-8."""
    image = Image({"color": picture(2, 3)}, {"scene": "caf\udce9.glb"})
    write_exr(tmp_path / "a.exr", image)
    assert read_exr(tmp_path / "a.exr").metadata == {"scene": "caf\\udce9.glb"}


def test_the_same_image_makes_the_same_file(tmp_path):
    image = Image({"color": picture(5, 6)}, {"seed": "0"})
    for name in ("a", "b"):
        write_exr(tmp_path / name, image)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_two_layers_of_one_channel_are_refused(tmp_path):
    image = Image({"color": picture(2, 3), "G": picture(2, 3, 1)})
    with pytest.raises(ValueError, match="channel 'G'"):
        write_exr(tmp_path / "a.exr", image)
    assert not list(tmp_path.iterdir())


# ---------------------------------------------------------------- foreign files


def test_a_half_float_file_is_read(tmp_path):
    half = picture(4, 5).astype(np.float16)
    color = read_exr(save(tmp_path / "a.exr", {"RGB": half})).color
    assert_same_bits(color, half.astype(np.float32))


def test_luminance_alone_is_grey(tmp_path):
    y = picture(4, 5)[..., 0].copy()
    color = read_exr(save(tmp_path / "a.exr", {"Y": y})).color
    assert_same_bits(color, np.stack([y, y, y], axis=-1))


def test_the_only_layer_with_colours_is_the_picture(tmp_path):
    rgb, depth = picture(4, 5), picture(4, 5)[..., 0].copy()
    path = save(tmp_path / "a.exr", {"View.Combined": rgb, "View.Depth.Z": depth})
    image = read_exr(path)
    assert_same_bits(image.color, rgb)
    assert image.layers.keys() == {"color", "View.Depth.Z"}


def test_alpha_and_ids_become_layers_of_their_own(tmp_path):
    rgba, ids = picture(4, 5, 4), np.arange(20, dtype=np.uint32).reshape(4, 5)
    image = read_exr(save(tmp_path / "a.exr", {"RGBA": rgba, "id": ids}))
    assert_same_bits(image.color, rgba[..., :3].copy())
    assert_same_bits(image.layers["A"], rgba[..., 3:].copy())
    assert image.layers["id"][3, 4, 0] == 19


def test_a_layer_called_color_does_not_replace_the_picture(tmp_path):
    rgb, other = picture(4, 5), picture(4, 5, seed=1)
    path = save(tmp_path / "a.exr", {"RGB": rgb, "color": other})
    assert_same_bits(read_exr(path).color, rgb)


def test_a_tiled_file_is_read(tmp_path):
    rgb = picture(40, 50)
    header = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
    path = save(tmp_path / "a.exr", {"RGB": rgb}, header)
    assert_same_bits(read_exr(path).color, rgb)


def test_several_parts_of_one_size_are_layers(tmp_path):
    rgb, z = picture(4, 5), picture(4, 5)[..., 0].copy()
    parts = [
        OpenEXR.Part(dict(SCAN), {"RGB": rgb}, "beauty"),
        OpenEXR.Part(dict(SCAN), {"Z": z}, "depth"),
    ]
    OpenEXR.File(parts).write(str(tmp_path / "a.exr"))
    image = read_exr(tmp_path / "a.exr")
    assert_same_bits(image.color, rgb)
    assert_same_bits(image.layers["depth.Z"][..., 0].copy(), z)


def test_a_window_that_does_not_start_at_0_is_read(tmp_path):
    window = ((10, 20), (14, 23))
    header = SCAN | {"dataWindow": window, "displayWindow": window}
    rgb = picture(4, 5)
    path = save(tmp_path / "a.exr", {"RGB": rgb}, header)
    assert_same_bits(read_exr(path).color, rgb)


def test_text_attributes_of_others_are_kept(tmp_path):
    header = SCAN | {"owner": "somebody", "isoSpeed": 100.0}
    path = save(tmp_path / "a.exr", {"RGB": picture(4, 5)}, header)
    assert read_exr(path).metadata == {"owner": "somebody"}
