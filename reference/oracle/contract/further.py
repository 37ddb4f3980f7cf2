"""Further passes of the contract: what stands around the resampling of a frame."""

from restir_gi.reference.oracle.contract.fields import (
    Pass,
    Setting,
    bits,
    index,
    real,
    vector,
)
from restir_gi.reference.oracle.contract.groups import RESERVOIR
from restir_gi.reference.oracle.contract.kernels import SIMILAR
from restir_gi.reference.oracle.contract.packing import PACK, UNPACK

WIDTH = Setting("width", "pixels", "of the image; row = y · width + x")
FRAME = Setting("frame", "whole number, 0 to 2²⁷ − 1", "of now")
PIXEL = index("pixel", "row y · width + x of a pixel; y counts downwards")
WEIGHTS = RESERVOIR[3:]


def _along_axes(name: str, meaning: str) -> tuple[Setting, ...]:
    return tuple(Setting(f"{name}_{axis}", "number", meaning) for axis in "xyz")


CAMERA = (
    *_along_axes("eye", "pinhole of the camera, m"),
    *_along_axes("target", "point that is seen in the centre of the image, m"),
    *_along_axes("up", "not parallel to the view; not orthogonal to it, nor unit"),
    Setting("fov_x", "degrees, 0 to 180", "horizontal angle of view"),
    WIDTH,
    Setting("height", "pixels", "of the image; pixels are square"),
)

_AXES = (
    "forward = (target − eye) / |target − eye|, right = (forward × up) / |forward × up|"
    ", upward = right × forward, h = tan(fov_x / 2);\n"
)

GBUFFER = Pass(
    name="gbuffer",
    summary="The visible point of a pixel, on the triangle that lies on its ray",
    formula=(
        _AXES + "x = pixel mod width + 1/2, y = ⌊pixel / width⌋ + 1/2;\n"
        "d = (2x / width − 1) h right + (height − 2y) / width h upward + forward;\n"
        "n = (b − a) × (c − a), t = n·(a − eye) / n·d, p = eye + t d;\n"
        "hit where t > 0 and p is inside of the triangle: n·((b − a) × (p − a)), "
        "n·((c − b) × (p − b)) and n·((a − c) × (p − c)) are above 0;\n"
        "position = p; normal = n / |n|, or its negative where n·d > 0; "
        "depth = forward·(p − eye); all 0 where there is no hit"
    ),
    inputs=(
        PIXEL,
        vector("a", "first corner of the triangle, m"),
        vector("b", "second corner, m"),
        vector("c", "third corner, m"),
    ),
    outputs=(
        bits("hit", "1 where the ray meets the triangle, else 0"),
        vector("position", "visible point x, m"),
        vector("normal", "unit normal, on the side that is seen"),
        real("depth", "view depth along the camera's axis, m"),
    ),
    settings=CAMERA,
    source="[Ouyang21, section 5], for flat triangles and one ray through the centre",
    clauses=(
        "rays go through the centres of pixels",
        "y counts downwards, x to the right",
        "the angle of view is the horizontal one",
        "up is made orthogonal to the view",
        "the depth is along the axis",
        "nothing behind the pinhole is hit",
        "the normal is turned to the side that is seen",
        "triangles are met from both sides",
        "all is 0 where there is no hit",
    ),
)

REPROJECT = Pass(
    name="reproject",
    summary="The pixel of the last frame that saw what a pixel sees now",
    formula=(
        _AXES + "all of the last frame's camera; o = position − eye, z = o·forward;\n"
        "x = width / 2 + (o·right) width / (2 z h), "
        "y = height / 2 − (o·upward) width / (2 z h);\n"
        "row = ⌊y⌋ · width + ⌊x⌋ where hit, z > 0, 0 ≤ x < width, 0 ≤ y < height, and "
        "the point is similar to what that row saw: n·n_row ≥ cos(max_angle), "
        "|z − z_row| ≤ max_depth · max(z, z_row), z_row > 0; else row = −1"
    ),
    inputs=(
        vector("position", "visible point of this frame, where it was in the last, m"),
        vector("normal", "its unit normal, as it was in the last frame"),
        bits("hit", "1 where this frame sees something, else 0"),
        vector("normal_before", "unit normals that the last frame saw"),
        real("depth_before", "view depths of the last frame, m; 0 for nothing seen"),
    ),
    outputs=(index("row", "of the last frame, or −1"),),
    settings=(*CAMERA, *SIMILAR.settings),
    source="[Ouyang21, section 5]; the rows are all pixels of the image, in order",
    clauses=(
        "the place is cut off to a whole pixel",
        "places outside of the image have no row",
        "points behind the pinhole have no row",
        "misses have no row",
        "the normal is that of the place before",
        "the depth is that of the place before",
        "the depths differ by max_depth of the larger at most",
        "the angle of view is the horizontal one",
        "up is made orthogonal to the view",
    ),
)

VALIDATION = Pass(
    name="validation",
    summary="Reservoirs are emptied whose sample is no longer what it was",
    formula=(
        "a = Y(radiance_then), b = Y(radiance_now), "
        "luminance Y = 0.2126 R + 0.7152 G + 0.0722 B;\n"
        "W and M stay where null is 1, and where met is 1 and "
        "|a − b| ≤ tolerance · max(a, b); else both become 0"
    ),
    inputs=(
        *WEIGHTS,
        vector("radiance_then", "radiance L_o that was stored, W/(m² sr)"),
        vector("radiance_now", "found again with the same random numbers"),
        bits("met", "1 where a ray to the sample point still meets it, else 0"),
        bits("null", "1 where the path that made the sample met nothing, else 0"),
    ),
    outputs=WEIGHTS,
    settings=(Setting("tolerance", "number, 0 to 1", "relative change of luminance"),),
    source="[Ouyang21, section 4.3]",
    clauses=(
        "the tolerance is relative to the larger luminance",
        "luminance has the weights of Rec. 709",
        "samples that became darker, and brighter, are cleared",
        "nulls stay",
        "a sample that is no longer met is cleared",
        "M is cleared too",
    ),
)

BOILING = Pass(
    name="boiling",
    summary="Reservoirs are emptied that outshine their tile",
    formula=(
        "light = Y(radiance) · W, luminance Y = 0.2126 R + 0.7152 G + 0.0722 B;\n"
        "tiles of 16 × 16 pixels from the top left, cut off at the right and below;\n"
        "mean over the pixels of the tile whose light is above 0;\n"
        "W and M stay where light · strength ≤ mean · (10 − 9 strength); else both "
        "become 0"
    ),
    inputs=RESERVOIR[2:],
    outputs=WEIGHTS,
    settings=(WIDTH, Setting("strength", "number above 0, to 1", "of the filter")),
    source="the rows are all pixels of the image, in order",
    clauses=(
        "light is luminance times W",
        "luminance has the weights of Rec. 709",
        "the mean is that of pixels with light",
        "tiles have 16 × 16 pixels and are cut off",
        "the limit has the strength in both factors",
        "M is cleared too",
    ),
)

CHECKERBOARD = Pass(
    name="checkerboard",
    summary="Which pixels draw a new sample in this frame",
    formula=(
        "x = pixel mod width, y = ⌊pixel / width⌋;\n"
        "1 where x + y + frame is even, and where has_history is 0; else 0"
    ),
    inputs=(
        PIXEL,
        bits("has_history", "1 where the pixel goes on from the last frame, else 0"),
    ),
    outputs=(bits("draws", "1 or 0"),),
    settings=(WIDTH, FRAME),
    clauses=(
        "the half changes from frame to frame",
        "rows and columns take turns",
        "pixels without history draw",
    ),
)

ROULETTE = Pass(
    name="roulette",
    summary="Weight of all that lies beyond the first bounce of a path",
    formula=(
        "x = pixel mod width, y = ⌊pixel / width⌋;\n"
        "tile = ⌊y / 32⌋ · ⌈width / 64⌉ + ⌊x / 64⌋;\n"
        "u = u₀ of pass random for the key (tile, frame, seed, 7 · 64);\n"
        "weight = 1 / probability where u < probability, else 0"
    ),
    inputs=(PIXEL,),
    outputs=(real("weight", "of the tail; the first bounce is not weighted"),),
    settings=(
        WIDTH,
        FRAME,
        Setting("seed", "whole number, 0 to 2²⁷ − 1", "of the run"),
        Setting("probability", "number above 0, to 1", "share of tiles that go on"),
    ),
    source="[Ouyang21, section 5]",
    clauses=(
        "tiles decide together, and are cut off at the right",
        "the frame and the seed are in the key",
        "what goes on is divided by the probability",
        "u = probability does not go on",
    ),
)

FURTHER_PASSES = (
    GBUFFER,
    REPROJECT,
    VALIDATION,
    BOILING,
    CHECKERBOARD,
    ROULETTE,
    PACK,
    UNPACK,
)
