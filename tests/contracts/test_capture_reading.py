"""Buffers of a capture in all the ways in which they may lie, and what they become."""

import struct
from types import MappingProxyType

import numpy as np
import OpenEXR
import pytest

from restir_gi.reference.oracle.capture.faults import CaptureError
from restir_gi.reference.oracle.capture.record import Capture
from restir_gi.reference.scene.camera import Camera, camera_rays, pixel_centers
from restir_gi.reference.system.errors import UsageError

WIDTH, HEIGHT = 5, 3
ROWS = WIDTH * HEIGHT
NUMBERS = np.arange(ROWS, dtype="<f4")

HEAD = f"""
schema = "restir-capture 1"
width = {WIDTH}
height = {HEIGHT}
frames = [0]
"""


@pytest.fixture
def read(tmp_path):
    """Write files and a manifest, and read them."""

    def run(tables, head=HEAD, **files):
        for name, contents in files.items():
            path = tmp_path / name.replace("__", ".")
            path.write_bytes(contents)
        (tmp_path / "capture.toml").write_text(head + tables, encoding="utf-8")
        return Capture.read(tmp_path)

    return run


def one(name, keys, kind="float32", role="temporal"):
    """A table of a buffer with one field."""
    kind = f'kind = "{kind}", ' if kind else ""
    return f"""
[buffers.it]
role = "{role}"
file = "it.bin"
{keys}
fields = [{{ {kind}name = "{name}" }}]
"""


def arrays(tables, *frames, width=WIDTH, height=HEIGHT, **manifest):
    """Read arrays in place of files."""
    return Capture.from_arrays(
        width=width,
        height=height,
        frames=frames,
        manifest={"buffers": tables, **manifest},
    )


def told(action, *parts):
    """The faults of a capture; each part stands in one of them."""
    with pytest.raises(CaptureError) as caught:
        action()
    assert "\n" not in str(caught.value)
    for part in parts:
        assert part in str(caught.value)
    return caught.value.faults


# ---------------------------------------------------------------- order


def test_rows_from_the_top(read):
    capture = read(one("M", ""), it__bin=NUMBERS.tobytes())
    assert capture.frames[0]["temporal"]["M"].tolist() == list(range(ROWS))
    assert (capture.width, capture.height, capture.rows) == (WIDTH, HEIGHT, ROWS)


def test_the_bottom_row_first(read):
    found = read(one("M", "flip = true"), it__bin=NUMBERS.tobytes())
    expected = np.arange(ROWS).reshape(HEIGHT, WIDTH)[::-1].ravel()
    assert found.frames[0]["temporal"]["M"].tolist() == expected.tolist()


def walked(width, height, tile):
    """Pixels in the order of a buffer of whole tiles, walked with loops; None: none."""
    order = []
    for top in range(0, height, tile[1]):
        for left in range(0, width, tile[0]):
            for y in range(top, top + tile[1]):
                for x in range(left, left + tile[0]):
                    order.append((x, y) if x < width and y < height else None)
    return order


@pytest.mark.parametrize("tile", [(2, 2), (4, 1), (1, 3), (5, 3), (16, 16)])
def test_tiles_are_whole_at_the_edges(read, tile):
    order = walked(WIDTH, HEIGHT, tile)
    numbers = [-1.0 if at is None else at[1] * WIDTH + at[0] for at in order]
    keys = f'order = "tiles"\ntile = {list(tile)}'
    data = np.array(numbers, "<f4").tobytes()
    for more, whole in (("", data), ("\noffset = 8", b"8 before" + data)):
        found = read(one("M", keys + more), it__bin=whole)
        assert found.frames[0]["temporal"]["M"].tolist() == list(range(ROWS))


def test_a_texture_with_padded_rows(read):
    pitch = 32
    padded = b"".join(
        NUMBERS[y * WIDTH : (y + 1) * WIDTH].tobytes().ljust(pitch, b"\xff")
        for y in range(HEIGHT)
    )
    keys = f"row_pitch = {pitch}"
    expected = list(range(ROWS))
    for data in (padded, padded[: -(pitch - 4 * WIDTH)]):
        found = read(one("M", keys), it__bin=data)
        assert found.frames[0]["temporal"]["M"].tolist() == expected


def test_structs_with_a_header_and_slots(read):
    """The second field of structs of 12 bytes, in the second of two slots."""
    slots = [
        b"".join(struct.pack("<fIf", 9.0, row + 100 * slot, 9.0) for row in range(ROWS))
        for slot in range(2)
    ]
    tables = """
[buffers.it]
role = "temporal"
file = "it.bin"
stride = 12
offset = 3
slots = 2
slot = 1
fields = [{ name = "seed", kind = "uint32", offset = 4 }]
"""
    found = read(tables, it__bin=b"abc" + b"".join(slots)).frames[0]["temporal"]
    assert found["seed"].tolist() == [row + 100 for row in range(ROWS)]
    assert found["seed"].dtype == np.uint32
    assert found.words["it"].tobytes() == slots[1]


def test_a_vector_from_several_buffers():
    tables = {
        name: {
            "role": "gbuffer",
            "fields": [
                {"name": "visible_position", "kind": "float32", "component": k},
            ],
        }
        for k, name in enumerate("xyz")
    }
    columns = [NUMBERS + 100 * k for k in range(3)]
    frame = dict(zip("xyz", columns, strict=True))
    found = arrays(tables, frame).frames[0]["gbuffer"]["visible_position"]
    assert np.array_equal(found, np.stack(columns, axis=-1))


def test_names_of_frames(read, tmp_path):
    head = HEAD.replace("[0]", "[7, 12]")
    table = one("M", "").replace("it.bin", "sub/it.{frame:04}.bin")
    (tmp_path / "sub").mkdir()
    for number in (7, 12):
        data = (NUMBERS + number).tobytes()
        (tmp_path / f"sub/it.00{number:02}.bin").write_bytes(data)
    capture = read(table, head)
    assert [frame.number for frame in capture.frames] == [7, 12]
    assert [frame["temporal"]["M"][0] for frame in capture.frames] == [7, 12]
    assert capture.before(1) is None


def test_the_frame_before_and_what_it_saw(read, tmp_path):
    head = HEAD.replace("[0]", "[3, 4, 5]")
    table = one("depth", "", role="gbuffer").replace("it.bin", "it{frame}.bin")
    table += one("depth", "frames = [5]", role="previous_gbuffer").replace(
        "[buffers.it]", "[buffers.before]"
    )
    files = {f"it{k}__bin": (NUMBERS + k).tobytes() for k in (3, 4, 5)}
    capture = read(table, head, it__bin=(NUMBERS + 50).tobytes(), **files)
    first = [capture.previous_gbuffer(k) for k in range(3)]
    assert first[0] is None
    assert first[1]["depth"][0] == 3
    assert first[2]["depth"][0] == 50
    assert "previous_gbuffer" not in capture.frames[1]


# ---------------------------------------------------------------- forms


def test_arrays_in_files(read, tmp_path):
    image = NUMBERS.reshape(HEIGHT, WIDTH)
    np.save(tmp_path / "it.npy", image)
    np.savez_compressed(tmp_path / "it.npz", a=image, b=NUMBERS[:, None] + 1)
    table = one("M", "", kind="")
    for keys, first in (
        ("it.npy", 0),
        ('it.npz"\nmember = "a', 0),
        ('it.npz"\nmember = "b', 1),
    ):
        found = read(table.replace("it.bin", keys)).frames[0]["temporal"]
        assert found["M"].tolist() == [first + k for k in range(ROWS)]
        assert found.formats["M"] == "float32"
        assert found.words == {}


def test_an_array_of_columns():
    data = np.arange(ROWS * 4.0).reshape(HEIGHT, WIDTH, 4)
    fields = [{"name": "radiance", "column": 1}, {"name": "W"}]
    table = {"role": "temporal", "fields": fields, "flip": True}
    found = arrays({"it": table}, {"it": data}).frames[0]["temporal"]
    flipped = data[::-1].reshape(ROWS, 4)
    assert np.array_equal(found["W"], flipped[:, 0])
    assert np.array_equal(found["radiance"], flipped[:, 1:])


@pytest.mark.parametrize("slot", [0, 1])
def test_slots_and_tiles_of_an_array(slot):
    order = walked(WIDTH, HEIGHT, (4, 2))
    rows = [-1 if at is None else at[1] * WIDTH + at[0] for at in order]
    data = np.concatenate([rows, np.array(rows) + 100])[:, None]
    table = {"role": "temporal", "fields": [{"name": "M"}], "slots": 2, "slot": slot}
    table |= {"order": "tiles", "tile": [4, 2]}
    found = arrays({"it": table}, {"it": data}).frames[0]["temporal"]["M"]
    assert found.tolist() == [row + 100 * slot for row in range(ROWS)]


def test_bytes_of_an_array(read, tmp_path):
    codes = np.zeros((HEIGHT, WIDTH), [("W", "<f4"), ("seed", "<u4")])
    codes["W"].flat, codes["seed"].flat = NUMBERS, np.arange(ROWS)
    np.save(tmp_path / "it.npy", codes)
    table = one("W", "stride = 8").replace("it.bin", "it.npy")
    found = read(table).frames[0]["temporal"]
    assert found["W"].tolist() == list(range(ROWS))
    assert found.words["it"].tobytes() == codes.tobytes()


def write_exr(path, **parts):
    OpenEXR.File(
        [
            OpenEXR.Part({"type": OpenEXR.scanlineimage}, channels, name)
            for name, channels in parts.items()
        ]
    ).write(str(path))


def test_pictures(read, tmp_path):
    image = NUMBERS.reshape(HEIGHT, WIDTH)
    rgb = {c: np.ascontiguousarray(image + k) for k, c in enumerate("RGB")}
    half = {"Y": image.astype(np.float16)}
    write_exr(tmp_path / "it.exr", light=rgb, weight=half)
    tables = """
[buffers.a]
role = "temporal"
file = "it.exr"
part = "light"
fields = [{ name = "radiance", channels = ["B", "G", "R"], scale = 2 }]
[buffers.b]
role = "temporal"
file = "it.exr"
part = "weight"
flip = true
fields = [{ name = "W", channels = ["Y"] }]
"""
    found = read(tables).frames[0]["temporal"]
    expected = 2 * np.stack([NUMBERS + 2, NUMBERS + 1, NUMBERS], axis=-1)
    assert np.array_equal(found["radiance"], expected)
    assert np.array_equal(found["W"], image[::-1].ravel())
    assert found.formats == {"radiance": "float32", "W": "float16"}
    swapped = tables.replace('part = "light"', 'part = "lihgt"')
    told(lambda: read(swapped), "unknown part 'lihgt'; did you mean light?")
    told(lambda: read(tables.replace('part = "light"', "")), "several parts")
    told(lambda: read(tables.replace('"B"', '"A"')), "unknown channel 'A'")


def test_a_picture_of_another_size(read, tmp_path):
    write_exr(tmp_path / "it.exr", a={"Y": np.zeros((WIDTH, HEIGHT), np.float32)})
    table = one("W", "", kind="").replace("it.bin", "it.exr")
    table = table.replace('"W" }', '"W", channels = ["Y"] }')
    told(lambda: read(table), f"has {HEIGHT}x{WIDTH} pixels", f"{WIDTH}x{HEIGHT}")


# ---------------------------------------------------------------- arrays of Python


CUDA = MappingProxyType({"shape": (ROWS,), "data": (1, False), "version": 3})


class OnDevice:
    """An array that says it is on a device, whose memory is the host's."""

    def __init__(self, array):
        self.array, self.copies = array, 0

    def _copy(self):
        self.copies += 1
        return self.array


class LikeCupy(OnDevice):
    """What copies itself by ``get``."""

    __cuda_array_interface__ = CUDA

    def get(self):
        """A copy in the host's memory."""
        return self._copy()


class LikeTorch(OnDevice):
    """What copies itself by ``cpu``, and hands over its memory nowhere else."""

    def __dlpack_device__(self):
        return (2, 0)

    def __dlpack__(self, **options):
        raise AssertionError("nobody may hand over a device's memory")

    def cpu(self):
        """Another such array, in the host's memory."""
        return OnHost(self._copy())


class OnHost:
    """What knows DLPack and nothing else."""

    def __init__(self, array):
        self.array = array

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()

    def __dlpack__(self, **options):
        return self.array.__dlpack__(**options)


class WithoutCopy:
    """What is on a device, and stays there."""

    __cuda_array_interface__ = CUDA


M_ALONE = {"it": {"role": "temporal", "fields": [{"name": "M", "kind": "float32"}]}}


@pytest.mark.parametrize(
    "wrapped", [LikeCupy, LikeTorch, OnHost, np.asarray, memoryview, bytes, bytearray]
)
def test_arrays_of_any_library(wrapped):
    given = wrapped(NUMBERS)
    found = arrays(M_ALONE, {"it": given})
    assert found.frames[0]["temporal"]["M"].tolist() == list(range(ROWS))
    assert getattr(given, "copies", 1) == 1


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (WithoutCopy(), "on a device, and has neither `get` nor `cpu`"),
        (object(), "object cannot be read as an array"),
        ([1.0, 2.0], "list cannot be read as an array"),
        (np.array(["a"] * ROWS), "has no numbers"),
        (np.array([None] * ROWS), "has no numbers"),
        (NUMBERS[:-1], "has 56 bytes where 15 pixels of 4 bytes make 60"),
    ],
)
def test_what_is_no_array_is_told(given, words):
    told(lambda: arrays(M_ALONE, {"it": given}), words)


def test_an_array_that_cannot_be_copied_is_told():
    def fail():
        raise RuntimeError("out of\nmemory")

    broken = LikeTorch(NUMBERS)
    broken.cpu = fail
    told(lambda: arrays(M_ALONE, {"it": broken}), "out of memory")


def test_arrays_that_are_missing():
    faults = told(lambda: arrays(M_ALONE, {}, {"it": NUMBERS}, {}))
    assert [fault[:14] for fault in faults] == ["frame 0: it: i", "frame 2: it: i"]
    table = {"it": {**M_ALONE["it"], "frames": [1]}}
    found = arrays(table, {}, {"it": NUMBERS})
    assert "temporal" not in found.frames[0]
    assert "temporal" in found.frames[1]


def test_sizes_of_manifest_and_arrays_agree():
    told(lambda: arrays(M_ALONE, {"it": NUMBERS}, frames=[0, 1]), "2 frames")
    told(lambda: arrays(M_ALONE, {"it": NUMBERS}, schema="x"), "schema is 'x'")


# ---------------------------------------------------------------- conversions


def test_the_weight_of_a_sum_of_weights():
    fields = [
        {"name": name, "column": k} for k, name in enumerate(("w_sum", "M", "p_hat"))
    ]
    table = {"it": {"role": "spatial", "fields": fields}}
    data = np.ones((ROWS, 3))
    data[:4] = [(6, 3, 0.5), (6, 0, 0.5), (6, 3, 0), (0, 3, 2)]
    found = arrays(table, {"it": data}).frames[0]["spatial"]
    assert found["W"].tolist()[:5] == [4, 0, 0, 0, 1]
    assert found.derived == {"W": "w_sum / (M p_hat)"}
    assert found.formats["W"] == "float64"


def test_the_density_of_new_samples():
    fields = [{"name": "W", "kind": "float32"}]
    tables = {role: {"fields": fields} for role in ("initial", "temporal")}
    data = np.full(ROWS, 4, np.float32)
    data[0] = 0
    frame = arrays(tables, dict.fromkeys(tables, data)).frames[0]
    assert frame["initial"]["pdf"].tolist() == [0] + [0.25] * (ROWS - 1)
    assert frame["initial"].derived == {"pdf": "1 / W"}
    assert "pdf" not in frame["temporal"]


NONE32 = 2**32 - 1


@pytest.mark.parametrize(
    ("field", "codes", "expected"),
    [
        ({"kind": "int32"}, [3, -1], [3, -1]),
        ({"kind": "uint32"}, [3, NONE32], [3, -1]),
        ({"kind": "uint16", "none": 14}, [3, 14], [3, -1]),
        ({"kind": "uint32", "bits": [0, 7]}, [0xA03, 0xAFF], [3, -1]),
        ({"kind": "float32"}, [3.0, -1.0], [3, -1]),
    ],
)
def test_history_as_rows(field, codes, expected):
    dtype = {"i": "<i4", "u": "<u4", "f": "<f4"}[field["kind"][0]]
    dtype = "<u2" if field["kind"] == "uint16" else dtype
    data = np.resize(np.array(codes, dtype), ROWS)
    table = {"history": {"fields": [{"name": "row", **field}]}}
    found = arrays(table, {"history": data}).frames[0]["history"]["row"]
    assert found.tolist() == np.resize(expected, ROWS).tolist()
    assert found.dtype == np.int64


def test_history_as_pixels_and_as_motion():
    """Pixel (x, y) continues (x − 1, y + 1): −1 at the left edge, and at the bottom."""
    x, y = np.arange(ROWS) % WIDTH, np.arange(ROWS) // WIDTH
    inside = (x > 0) & (y < HEIGHT - 1)
    expected = np.where(inside, (y + 1) * WIDTH + x - 1, -1).tolist()
    places = np.stack([x - 1 + 0.5, y + 1 + 0.25], axis=-1)
    shares = np.stack([np.full(ROWS, -1 / WIDTH), np.full(ROWS, 1 / HEIGHT)], axis=-1)
    for given, data, scale in (
        ("pixels", places, 1),
        ("pixels", np.floor(places).astype(np.int64), 1),
        ("offsets", np.tile([-1, 1], (ROWS, 1)), 1),
        ("offsets", np.tile([1, -1], (ROWS, 1)), -1),
        ("offsets", shares, [WIDTH, HEIGHT]),
    ):
        field = {"name": "row", "given": given, "scale": scale}
        capture = arrays({"history": {"fields": [field]}}, {"history": data})
        assert capture.frames[0]["history"]["row"].tolist() == expected
        # Of pixels (-1, y) are outside as well, and not none: both would have to be -1.
        outside = ROWS - int(inside.sum())
        assert f"row of history: {outside} lie outside" in capture.notes[0]


def test_where_rows_count_from_the_bottom_pixels_and_offsets_do():
    x, y = np.arange(ROWS) % WIDTH, np.arange(ROWS) // WIDTH
    up = HEIGHT - 1 - y  # of each pixel, from the bottom
    row = np.where(y > 0, (y - 1) * WIDTH + x, -1)  # the pixel above
    stored = {
        "rows": np.where(y > 0, (up + 1) * WIDTH + x, -1)[:, None],
        "pixels": np.stack([x, up + 1], axis=-1),
        "offsets": np.tile([0, 1], (ROWS, 1)),
    }
    for given, data in stored.items():
        flipped = data.reshape(HEIGHT, WIDTH, -1)[::-1].copy()
        field = {"name": "row", "given": given}
        table = {"history": {"fields": [field], "flip": True}}
        found = arrays(table, {"history": flipped}).frames[0]["history"]["row"]
        assert found.tolist() == row.tolist(), given


def test_neighbors_as_pairs_of_pixels():
    pairs = np.full((ROWS, 2, 2), 0xFFFF, "<u2")
    pairs[0] = [(4, 2), (0, 0)]
    pairs[1] = [(0xFFFF, 0xFFFF), (2, 1)]
    field = {"name": "neighbors", "kind": "uint16", "count": 4, "given": "pixels"}
    capture = arrays({"neighbors": {"fields": [field]}}, {"neighbors": pairs})
    found = capture.frames[0]["neighbors"]["neighbors"]
    assert found.shape == (ROWS, 2)
    assert found[:3].tolist() == [[14, 0], [-1, 7], [-1, -1]]
    assert capture.notes == ()


def test_no_row_of_the_image():
    table = {"neighbors": {"fields": [{"name": "neighbors", "count": 2}]}}
    data = np.zeros((ROWS, 2), np.int64)
    data[3, 1], data[4, 0] = ROWS, -7
    told(
        lambda: arrays(table, {"neighbors": data}),
        "neighbors of neighbors is 15 in 2 places; it should be a row from 0 to 14",
    )


def test_masks_and_targets():
    tables = {
        "visible_spatial": {
            "fields": [{"name": "visible", "kind": "uint8", "count": 3}]
        },
        "targets_spatial": {"fields": [{"name": "p_hat", "count": 2}]},
    }
    masks = np.tile(np.array([7, 0, 255], np.uint8), (ROWS, 1))
    targets = np.arange(2.0 * ROWS).reshape(ROWS, 2)
    frame = arrays(tables, dict(zip(tables, (masks, targets), strict=True))).frames[0]
    assert frame["visible_spatial"]["visible"].tolist() == masks.tolist()
    assert frame["visible_spatial"]["visible"].dtype == np.uint32
    assert np.array_equal(frame["targets_spatial"]["p_hat"], targets)
    wrong = {"visible_shade": {"fields": [{"name": "visible"}]}}
    told(
        lambda: arrays(wrong, {"visible_shade": np.full(ROWS, 0.5)}),
        "visible of visible_shade has 0.5, which is no whole number",
    )


# ---------------------------------------------------------------- positions

CAMERA = Camera(
    position=(1, 2, 5), target=(0.5, 0, -1), fov=50, width=WIDTH, height=HEIGHT
)
PINHOLE = {"position": [1, 2, 5], "target": [0.5, 0, -1], "fov": 50}


def seen():
    """Points at some depths along the axis, by the camera's own rays; and all three."""
    eye, direction = camera_rays(CAMERA, *pixel_centers(WIDTH, HEIGHT))
    cosine = direction @ CAMERA.axes[2]
    depth = np.linspace(1, 9, ROWS)
    return eye + (depth / cosine)[:, None] * direction, depth, depth / cosine


def projection(near, far, *, reverse, signed):
    """Projection times view, as textbooks build it: look along −z, then a frustum."""
    right, up, forward = CAMERA.axes
    view = np.eye(4)
    view[:3, :3] = right, up, -forward
    view[:3, 3] = -view[:3, :3] @ CAMERA.position
    half = np.tan(np.radians(25))
    a, b = (0.0, near) if reverse else (-far / (far - near), -far * near / (far - near))
    if signed:
        a, b = -(far + near) / (far - near), -2 * far * near / (far - near)
    frustum = np.array(
        [
            [1 / half, 0, 0, 0],
            [0, WIDTH / HEIGHT / half, 0, 0],
            [0, 0, a, b],
            [0, 0, -1, 0],
        ]
    )
    return frustum @ view


def of_depth(given, depth, **camera):
    field = {"name": "depth", "given": given}
    field |= {"none": camera.pop("none")} if "none" in camera else {}
    capture = arrays(
        {"gbuffer": {"fields": [field]}}, {"gbuffer": depth}, cameras=[camera]
    )
    return capture.frames[0]["gbuffer"]


def test_positions_from_depths_and_a_pinhole():
    points, depth, distance = seen()
    for given, stored in (("view", depth), ("distance", distance)):
        stored = stored.copy()
        stored[3] = 0
        found = of_depth(given, stored, **PINHOLE)
        expected = np.where(np.arange(ROWS)[:, None] == 3, 0, points)
        # A few operations on numbers below 16, each within 2⁻⁵³ of them.
        np.testing.assert_allclose(found["visible_position"], expected, atol=1e-14)
        np.testing.assert_allclose(found["depth"][4:], depth[4:], rtol=1e-14)
        assert found["depth"][3] == 0
        assert found.derived["visible_position"] == "from the depth"


@pytest.mark.parametrize("form", ["plain", "reverse", "signed", "down", "rows"])
def test_positions_from_the_inverse_of_projection_times_view(form):
    points, depth, distance = seen()
    whole = projection(0.1, 100, reverse=form == "reverse", signed=form == "signed")
    if form == "down":
        whole = np.diag([1, -1, 1, 1]) @ whole
    clip = np.c_[points, np.ones(ROWS)] @ whole.T
    device = clip[:, 2] / clip[:, 3]
    device = (device + 1) / 2 if form == "signed" else device
    inverse = np.linalg.inv(whole)
    camera = {"inverse_view_projection": inverse.tolist()}
    if form == "signed":
        camera["clip_depth"] = "-1 to 1"
    if form == "down":
        camera["clip_y"] = "down"
    if form == "rows":
        camera |= {"inverse_view_projection": inverse.T.tolist(), "row_vectors": True}
    for given, stored in (("view", depth), ("distance", distance), ("device", device)):
        found = of_depth(given, stored, **camera)
        # The inverse has numbers of 1 / near = 10, and depth moves by d² / near: 810
        # of a rounding of 2⁻⁵³, some dozen times.
        np.testing.assert_allclose(found["visible_position"], points, atol=1e-11)
        np.testing.assert_allclose(found["depth"], depth, atol=1e-11)


def test_what_a_depth_buffer_has_where_nothing_is_seen():
    points, _, _ = seen()
    whole = projection(0.1, 100, reverse=True, signed=False)
    clip = np.c_[points, np.ones(ROWS)] @ whole.T
    device = clip[:, 2] / clip[:, 3]
    device[2] = 0
    camera = {"inverse_view_projection": np.linalg.inv(whole).tolist()}
    found = of_depth("device", device, none=0, **camera)
    assert not found["visible_position"][2].any()
    assert found["depth"][2] == 0
    told(lambda: of_depth("device", device, **camera), "not finite", "`none`")


def test_control_another_convention_gives_other_positions():
    points, _, _ = seen()
    whole = projection(0.1, 100, reverse=False, signed=False)
    clip = np.c_[points, np.ones(ROWS)] @ whole.T
    device = clip[:, 2] / clip[:, 3]
    camera = {"inverse_view_projection": np.linalg.inv(whole).tolist()}
    for other in ({"clip_y": "down"}, {"row_vectors": True}, {"clip_depth": "-1 to 1"}):
        found = of_depth("device", device, **camera, **other)["visible_position"]
        assert abs(found - points).max() > 0.1


def test_depths_of_nothing_are_0_without_a_camera():
    field = {"name": "depth", "none": 65504}
    data = np.where(np.arange(ROWS) == 2, 65504, 3.0)
    found = arrays({"gbuffer": {"fields": [field]}}, {"gbuffer": data})
    depth = found.frames[0]["gbuffer"]["depth"]
    assert depth.tolist() == np.where(np.arange(ROWS) == 2, 0, 3).tolist()


def test_one_camera_for_all_frames_or_one_for_each():
    points, depth, _ = seen()
    table = {"gbuffer": {"fields": [{"name": "depth"}]}}
    moved = {**PINHOLE, "position": [1, 2, 6], "target": [0.5, 0, 0]}
    for cameras, step in (([PINHOLE], 0), ([PINHOLE, moved], 1)):
        frames = [{"gbuffer": depth}] * 2
        capture = arrays(table, *frames, cameras=cameras)
        for k, frame in enumerate(capture.frames):
            expected = points + np.array([0, 0, step * k])
            found = frame["gbuffer"]["visible_position"]
            np.testing.assert_allclose(found, expected, atol=1e-14)


def test_a_position_that_is_dumped_is_kept():
    points, depth, _ = seen()
    fields = [{"name": "visible_position"}, {"name": "depth", "column": 3}]
    data = np.c_[points + 1, depth]
    table = {"gbuffer": {"fields": fields}}
    frame = arrays(table, {"gbuffer": data}, cameras=[PINHOLE]).frames[0]
    assert np.array_equal(frame["gbuffer"]["visible_position"], points + 1)


# ---------------------------------------------------------------- what is wrong


def test_all_that_is_not_finite_is_told_at_once():
    fields = [{"name": "radiance"}, {"name": "W", "column": 3}]
    fields += [{"name": "M", "column": 4}]
    data = np.ones((ROWS, 5))
    data[7, 1] = np.nan
    data[8, :3] = np.inf
    data[12, 3] = -np.inf
    table = {"initial": {"fields": fields}}
    faults = told(lambda: arrays(table, {"initial": data}, {"initial": data}))
    assert faults[:2] == (
        "frame 0: radiance of initial is nan in 2 of 15 pixels, the first of them"
        " (2, 1); numbers should be finite",
        "frame 0: W of initial is -inf in 1 of 15 pixels, the first of them (2, 2);"
        " numbers should be finite",
    )
    assert len(faults) == 4


def test_what_a_factor_makes_infinite_is_told():
    table = {"initial": {"fields": [{"name": "W", "scale": 1e200}]}}
    data = np.full(ROWS, 1e200)
    told(lambda: arrays(table, {"initial": data}), "W of initial is inf in 15 of 15")


def test_what_a_pass_has_made_is_no_fault_of_the_capture():
    table = {"temporal": {"fields": [{"name": "W"}]}}
    data = np.ones(ROWS)
    data[7] = np.nan
    capture = arrays(table, {"temporal": data})
    assert np.isnan(capture.frames[0]["temporal"]["W"][7])
    assert "W of temporal is nan in 1 of 15 pixels" in capture.notes[0]


def test_weights_beyond_the_range_are_told():
    table = {"initial": {"fields": [{"name": "W"}]}}
    data = np.full(ROWS, 5e-324)
    told(
        lambda: arrays(table, {"initial": data}), "pdf of initial, 1 / W, is not finite"
    )


@pytest.mark.parametrize("kind", ["octahedral-float16", "octahedral-float32"])
def test_normals_that_are_not_finite_are_told(kind):
    data = np.zeros((ROWS, 2), "<f2" if kind.endswith("16") else "<f4")
    data[1, 0] = np.inf
    fields = [{"name": "normal", "kind": kind}]
    table = {"initial": {"fields": fields}}
    told(lambda: arrays(table, {"initial": data}), "normal of initial", "(1, 0)")


@pytest.mark.parametrize(
    ("keys", "size", "words"),
    [
        ("", 8 * ROWS, "has 120 bytes where 15 pixels of 4 bytes make 60; what would"
         " fit is stride = 8, or slots = 2"),
        ("", 4 * 256, "what would fit is order = \"tiles\", or"),
        ('order = "tiles"', 4 * ROWS, "256 pixels in tiles of 16x16 of 4 bytes make"
         " 1,024; what would fit is order = \"rows\""),
        ("", 3 * 256, "what would fit is row_pitch = 256"),
        ("", 4 * ROWS + 16, "what would fit is offset = 16"),
        ("row_pitch = 64", 3 * 256, "3 rows of 64 bytes make 192; what would fit is"
         " row_pitch = 256"),
        ("slots = 3\noffset = 2", 4 * ROWS + 2, "2 bytes and 3 slots of 15 pixels of 4"
         " bytes make 182; what would fit is slots = 1"),
        ("", 4 * ROWS - 1, "is it whole, and of this size of image?"),
        ("", 0, "has 0 bytes"),
    ],
)  # fmt: skip
def test_another_size_is_told_with_what_would_fit(read, keys, size, words):
    told(lambda: read(one("M", keys), it__bin=bytes(size)), words)


def test_files_that_are_missing_or_none(read, tmp_path):
    table = one("M", "")
    told(lambda: read(table), "it, it.bin: cannot read", "name a file that exists")
    (tmp_path / "it.bin").mkdir()
    told(lambda: read(table), "it is a folder")


def test_files_that_are_too_large_are_not_read(read, tmp_path):
    with (tmp_path / "it.bin").open("wb") as file:
        file.truncate(2**40)
    told(lambda: read(one("M", "")), "at most 65,776 can be read")
    with (tmp_path / "it.npz").open("wb") as file:
        np.savez_compressed(file, a=np.zeros(2**20))
    table = one("M", "", kind="").replace("it.bin", "it.npz")
    told(lambda: read(table), "has 8,388,736 bytes", "are allowed")


def test_arrays_of_other_shapes_are_told(read, tmp_path):
    table = one("M", "", kind="").replace("it.bin", "it.npy")
    for array, words in (
        (np.zeros((WIDTH, HEIGHT)), "has the shape (5, 3); it should begin with 15"),
        (np.zeros((ROWS, 0)), "has 0 columns, and its fields take 1"),
        (np.zeros(ROWS, complex), "complex128, and no numbers"),
        (np.zeros(ROWS, [("a", "f4")]), "give its fields a `kind`"),
    ):
        np.save(tmp_path / "it.npy", array)
        told(lambda: read(table), words)
    np.save(tmp_path / "it.npy", np.array([{}], object), allow_pickle=True)
    told(lambda: read(table), "cannot be read")
    (tmp_path / "it.npy").write_bytes(b"\x93NUMPY")
    told(lambda: read(table), "cannot be read")
    table = table.replace("it.npy", "it.npz")
    np.savez(tmp_path / "it.npz", a=NUMBERS, b=NUMBERS)
    told(lambda: read(table), "has 2 arrays; name one as `member`")
    named = table.replace('"it.npz"', '"it.npz"\nmember = "c"')
    told(lambda: read(named), "unknown member 'c'")


class WritesAFile:
    """What runs where somebody loads it as a pickle."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return type(self.path).touch, (self.path,)


@pytest.mark.parametrize("suffix", ["npy", "npz"])
def test_no_code_of_a_file_is_run(read, tmp_path, suffix):
    trace = tmp_path / "it ran"
    array = np.array([WritesAFile(trace)], object)
    save = np.save if suffix == "npy" else np.savez
    save(tmp_path / f"it.{suffix}", array, allow_pickle=True)
    table = one("M", "", kind="").replace("it.bin", f"it.{suffix}")
    told(lambda: read(table), "cannot be read")
    assert not trace.exists()


def test_control_code_of_a_file_would_run(tmp_path):
    trace = tmp_path / "it ran"
    np.save(tmp_path / "it.npy", np.array([WritesAFile(trace)], object))
    np.load(tmp_path / "it.npy", allow_pickle=True)
    assert trace.exists()


def test_what_lies_outside_of_the_folder_is_not_read(read):
    for name in ("/etc/passwd", "../it.bin", "a/../../b"):
        told(lambda name=name: read(one("M", "").replace("it.bin", name)), "below the")


def test_a_folder_without_a_manifest(tmp_path):
    with pytest.raises(UsageError, match=r"capture\.toml: No such file"):
        Capture.read(tmp_path)
