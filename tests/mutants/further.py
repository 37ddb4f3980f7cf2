"""Mistakes in the passes that stand around the resampling of a frame.

In the manner of :mod:`tests.mutants.catalogue`.
"""

from tests.mutants.catalogue import Mutant

REPROJECT = "restir_gi.reference.options.reprojection"
VALIDATION = "restir_gi.reference.options.validation"
BOILING = "restir_gi.reference.options.boiling"
CHECKERBOARD = "restir_gi.reference.options.checkerboard"
ROULETTE = "restir_gi.reference.options.roulette"
CAMERA = "restir_gi.reference.scene.camera"
OWN = "restir_gi.reference.oracle.builtin.further"
PAPER = "restir_gi.reference.resampling.packing.paper"
OCTAHEDRAL = "restir_gi.reference.resampling.packing.octahedral"
ROUNDING = "restir_gi.reference.resampling.packing.rounding"

CENTER = "camera_rays(camera, column + 0.5, line + 0.5)"
SIDE = "np.where(facing > 0, -1.0, 1.0)"
HALF_WIDTH = "half_width = camera.half_width\n"
ALONG_RIGHT = f"{HALF_WIDTH}    along_right"
SCALE = f"{HALF_WIDTH}    scale"
OF_HEIGHT = HALF_WIDTH.replace("\n", " * camera.width / camera.height\n")
DEPTH = "return dot(points - np.asarray(camera.position, float), forward)"

INSIDE = "inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)"
BEFORE = "return np.where(surface.hit, x, np.nan), np.where(surface.hit, y, np.nan)"
ALIKE = "return np.where(alike, row, NONE)"

SAME = "same = np.abs(now - then) <= tolerance * np.maximum(now, then)"
NOW = "now = luminance(replay.radiance(world, suffix, there))"
THEN = "then = luminance(y.radiance)"
VALID = "valid = ~met_something | (there & same)"
M_VALID = "M=np.where(valid, r.M, 0.0)"

LIGHT = "saturate(luminance(r.y.radiance) * r.W)"
COUNT = "np.bincount(tile, light > 0)[tile]"
MEAN = "mean = np.bincount(tile, divide_or_zero(light, count))[tile]"
CALM = "light * strength <= mean * (10.0 - 9.0 * strength) * ROUNDING"
M_CALM = "M=np.where(calm, r.M, 0.0)"
ACROSS = "across = -(-width // TILE)"

TURN = "(rows % width + rows // width + frame) % 2 == 0"
WEIGHT = "np.where(u < probability, 1.0 / probability, 0.0)"
TILE_ROW = "tile = (y // TILE_HEIGHT * across + x // TILE_WIDTH).astype(np.uint32)"

NORMAL_THEN = 'codes["n_v"] = encode_normal(n_v)'
NORMAL_THERE = 'codes["n_s"] = encode_normal(r.y.normal)'
RADIANCE = 'codes["L_o"] = nearest_float(r.y.radiance, np.float16)'
PACKED = 'codes["seed"] = seed\n    return codes'
FOLDED_OUT = "u, v = _fold_where(n[:, 2] < 0, u, v)"
FOLDED_IN = "x, y = _fold_where(z < 0, u, v)"
SIGNS = "sign_u, sign_v = np.where(u < 0, -1, 1), np.where(v < 0, -1, 1)"
CODES = "codes: NDArray[np.int16] = np.stack([u, v], axis=-1).astype(np.int16)"
COUNTED = "count = np.where(x > 0, np.clip(np.rint(x), 1, most), 0)"

VIEW = [
    Mutant(
        "rays go through the corners of pixels",
        ("TR-05",),
        OWN,
        CENTER,
        "camera_rays(camera, column, line)",
        ("pixel-corner",),
    ),
    Mutant(
        "the image is upside down",
        (),
        CAMERA,
        "(camera.height - 2.0 * y)",
        "(2.0 * y - camera.height)",
        ("image-upside-down",),
    ),
    Mutant(
        "the angle of view is that of the height",
        (),
        CAMERA,
        ALONG_RIGHT,
        f"{OF_HEIGHT}    along_right",
        ("angle-of-the-height",),
        also=((CAMERA, SCALE, f"{OF_HEIGHT}    scale"),),
    ),
    Mutant(
        "the up vector is used as it stands",
        (),
        CAMERA,
        "upwards = np.cross(right, forward)",
        "upwards = up",
        ("up-as-it-is",),
    ),
    Mutant(
        "normals keep the side that the triangle was wound for",
        ("SR-21",),
        OWN,
        SIDE,
        "np.ones_like(facing)",
        ("normal-not-turned",),
    ),
    Mutant(
        "what lies behind the camera is seen",
        (),
        OWN,
        "[ahead, t > 0, *sides]",
        "[ahead, *sides]",
        ("behind-the-camera",),
    ),
    Mutant(
        "the depth is the distance",
        ("TR-19",),
        CAMERA,
        DEPTH,
        "offset = points - np.asarray(camera.position, float)\n"
        "    return np.sqrt(dot(offset, offset))",
        ("distance-for-depth",),
    ),
]

BEFORE_NOW = [
    Mutant(
        "the place before is rounded",
        ("TR-05",),
        REPROJECT,
        INSIDE,
        f"x, y = np.floor(x + 0.5), np.floor(y + 0.5)\n    {INSIDE}",
        ("place-rounded",),
        "variance",
    ),
    Mutant(
        "the place before is half a pixel aside",
        ("TR-05",),
        CAMERA,
        "x = camera.width / 2 + dot(offset, right) * scale\n"
        "    y = camera.height / 2 - dot(offset, up) * scale",
        "x = camera.width / 2 + dot(offset, right) * scale - 0.5\n"
        "    y = camera.height / 2 - dot(offset, up) * scale - 0.5",
        ("place-half-a-pixel-aside",),
        "variance",
    ),
    Mutant(
        "places left and above of the image are cut to it",
        ("TR-05", "SR-13"),
        REPROJECT,
        INSIDE,
        "inside = (x > -1) & (x < width) & (y > -1) & (y < height)",
        ("place-truncated",),
        "variance",
    ),
    Mutant(
        "the pixel after the last is in the image",
        ("SR-13",),
        REPROJECT,
        INSIDE,
        "inside = (x >= 0) & (x < width + 1) & (y >= 0) & (y < height)",
        ("place-beyond-the-border",),
        "robustness",
    ),
    Mutant(
        "places outside are moved to the border",
        ("SR-13",),
        REPROJECT,
        INSIDE,
        "inside = ~np.isnan(x)\n"
        "    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)",
        ("place-clamped",),
        "variance",
    ),
    Mutant(
        "y before counts upwards",
        ("TR-05",),
        CAMERA,
        "y = camera.height / 2 - dot(offset, up) * scale",
        "y = camera.height / 2 + dot(offset, up) * scale",
        ("image-upside-down",),
        "variance",
    ),
    Mutant(
        "nothing is compared with the last frame",
        ("TR-19",),
        REPROJECT,
        ALIKE,
        "return row",
        ("similarity-not-tested",),
    ),
    Mutant(
        "normals are not compared with the last frame's",
        ("TR-19",),
        REPROJECT,
        "settings.max_angle,",
        "180.0,",
        ("normals-not-tested",),
    ),
    Mutant(
        "the depth is compared with that of the same pixel",
        ("TR-19",),
        REPROJECT,
        "seen_before.depth[row]",
        "seen_before.depth",
        ("own-depth-tested",),
    ),
    Mutant(
        "the depth before is that from this frame's camera",
        ("TR-13", "TR-19"),
        REPROJECT,
        "view_depth(before.camera",
        "view_depth(world.camera",
    ),
    Mutant(
        "pixels that see nothing go on",
        ("TR-21",),
        REPROJECT,
        BEFORE,
        "return x, y",
        ("misses-go-on",),
        "robustness",
        ((REPROJECT, "np.where(surface.hit, depth, 0.0)", "depth"),),
    ),
    Mutant(
        "points behind the camera have a place in the image",
        ("TR-19",),
        CAMERA,
        "where=depth > 0",
        "where=depth != 0",
        (),
        "equivalent",
    ),
]

EMPTIED = [
    Mutant(
        "the tolerance is absolute",
        (),
        VALIDATION,
        SAME,
        "same = np.abs(now - then) <= tolerance",
        ("validation-absolute",),
    ),
    Mutant(
        "the tolerance is relative to the old luminance",
        (),
        VALIDATION,
        SAME,
        SAME.replace("np.maximum(now, then)", "then"),
        ("validation-relative-to-then",),
    ),
    Mutant(
        "what became darker alone is cleared",
        ("TR-09",),
        VALIDATION,
        SAME,
        SAME.replace("np.abs(now - then)", "(then - now)"),
        ("validation-of-darker-alone",),
    ),
    Mutant(
        "what became brighter alone is cleared",
        ("TR-09",),
        VALIDATION,
        SAME,
        SAME.replace("np.abs(now - then)", "(now - then)"),
        ("validation-of-brighter-alone",),
    ),
    Mutant(
        "nulls are cleared",
        ("RG-01", "RG-07"),
        VALIDATION,
        VALID,
        "valid = there & same",
        ("validation-clears-nulls",),
    ),
    Mutant(
        "M outlives its sample",
        ("TR-15",),
        VALIDATION,
        M_VALID,
        "M=r.M",
        ("validation-keeps-m",),
    ),
    Mutant(
        "nobody looks whether the sample is still met",
        ("TR-15",),
        VALIDATION,
        VALID,
        "valid = ~met_something | same",
        ("validation-without-ray",),
        also=((VALIDATION, NOW, NOW.replace("there", "met_something")),),
    ),
    Mutant(
        "each channel must be what it was",
        (),
        VALIDATION,
        SAME,
        f"{SAME}\n    same = same.all(axis=1)",
        ("validation-by-channels",),
        also=(
            (VALIDATION, NOW, "now = replay.radiance(world, suffix, there)"),
            (VALIDATION, THEN, "then = y.radiance"),
        ),
    ),
    Mutant(
        "the stored luminance is that of Rec. 601",
        ("PK-13",),
        VALIDATION,
        THEN,
        "then = y.radiance @ np.array([0.299, 0.587, 0.114])",
    ),
    Mutant(
        "dark pixels are in the mean",
        ("TR-07",),
        BOILING,
        COUNT,
        "np.bincount(tile)[tile]",
        ("boiling-mean-over-all",),
    ),
    Mutant(
        "W alone is compared with its mean",
        ("TR-07",),
        BOILING,
        LIGHT,
        "saturate(r.W)",
        ("boiling-by-w-alone",),
    ),
    Mutant(
        "radiance alone is compared with its mean",
        ("TR-07",),
        BOILING,
        LIGHT,
        "saturate(luminance(r.y.radiance))",
        ("boiling-without-w",),
    ),
    Mutant(
        "M outlives the filter",
        ("SR-25",),
        BOILING,
        M_CALM,
        "M=r.M",
        ("boiling-keeps-m",),
    ),
    Mutant(
        "the mean is that of the image",
        ("TR-07",),
        BOILING,
        MEAN,
        "mean = np.full(len(light), light.sum() / max((light > 0).sum(), 1))",
        ("boiling-mean-of-the-image",),
    ),
    Mutant(
        "the limit is not divided by the strength",
        ("TR-07",),
        BOILING,
        CALM,
        CALM.replace("light * strength", "light"),
        ("boiling-limit-not-divided",),
    ),
    Mutant(
        "the filter's tiles are rounded down",
        ("HG-25",),
        BOILING,
        ACROSS,
        "across = width // TILE",
        ("boiling-tiles-rounded-down",),
    ),
]

TURNS = [
    Mutant(
        "the same half of the board draws in all frames",
        ("IN-01",),
        CHECKERBOARD,
        TURN,
        TURN.replace(" + frame", ""),
        ("checkerboard-stands-still",),
    ),
    Mutant(
        "columns in place of a checkerboard",
        (),
        CHECKERBOARD,
        TURN,
        TURN.replace(" + rows // width", ""),
        ("checkerboard-of-columns",),
        "variance",
    ),
    Mutant(
        "who has no history waits for its turn",
        ("SR-31",),
        CHECKERBOARD,
        "turn | ~has_history",
        "turn",
        ("checkerboard-without-history",),
    ),
    Mutant(
        "the other half begins",
        (),
        CHECKERBOARD,
        TURN,
        TURN.replace("== 0", "== 1"),
        ("checkerboard-other-half",),
        "variance",
    ),
    Mutant(
        "the tail is not divided by the probability",
        ("IS-15",),
        ROULETTE,
        WEIGHT,
        "np.where(u < probability, 1.0, 0.0)",
        ("roulette-not-divided",),
    ),
    Mutant(
        "each pixel decides on its own",
        (),
        ROULETTE,
        TILE_ROW,
        "tile = pixel.astype(np.uint32)",
        ("roulette-by-pixels",),
        "variance",
    ),
    Mutant(
        "the tiles of the roulette are rounded down",
        ("HG-25",),
        ROULETTE,
        "across = -(-width // TILE_WIDTH)",
        "across = width // TILE_WIDTH",
        ("roulette-tiles-rounded-down",),
        "variance",
    ),
    Mutant(
        "the same tiles go on in all frames",
        ("IN-01",),
        ROULETTE,
        "KeyedUniforms(tile, frame, seed",
        "KeyedUniforms(tile, frame * 0, seed",
        ("roulette-stands-still",),
    ),
    Mutant(
        "what does not go on keeps its tail",
        ("IS-15",),
        ROULETTE,
        WEIGHT,
        "np.where(u < probability, 1.0 / probability, 1.0)",
    ),
]

PACKED_BITS = [
    Mutant(
        "halves overflow to infinity",
        ("PK-01",),
        ROUNDING,
        "return _finite(rounded)",
        "return rounded",
        ("pack-halves-overflow",),
        "robustness",
    ),
    Mutant(
        "halves are rounded toward 0",
        ("PK-07",),
        ROUNDING,
        "rounded = x.astype(dtype)",
        "rounded = x.astype(dtype)\n"
        "        large = abs(rounded.astype(float)) > abs(x.astype(float))\n"
        "        rounded[large] = np.nextafter(rounded[large], dtype(0))",
        ("pack-halves-toward-0",),
    ),
    Mutant(
        "dim radiance becomes 0",
        ("PK-09",),
        PAPER,
        RADIANCE,
        f"{RADIANCE}\n"
        '    codes["L_o"] = np.where(codes["L_o"] < 2.0**-14, 0, codes["L_o"])',
        ("small-halves-are-0",),
    ),
    Mutant(
        "the sign of 0 is 0",
        ("PK-03",),
        OCTAHEDRAL,
        SIGNS,
        "sign_u, sign_v = np.sign(u), np.sign(v)",
        ("sign-of-0-is-0",),
    ),
    Mutant(
        "the lower half is not folded out",
        ("PK-03",),
        OCTAHEDRAL,
        FOLDED_OUT,
        "u, v = _fold_where(n[:, 2] < -2, u, v)",
        ("octahedron-not-folded",),
    ),
    Mutant(
        "the lower half is not folded in",
        ("PK-03",),
        OCTAHEDRAL,
        FOLDED_IN,
        "x, y = u, v",
        ("octahedron-not-folded",),
    ),
    Mutant(
        "a negative u runs over v",
        ("PK-05",),
        OCTAHEDRAL,
        CODES,
        "v = np.where(u < 0, -1, v)\n    codes = np.stack([u, v], -1).astype(np.int16)",
        ("pack-sign-runs-over",),
    ),
    Mutant(
        "normals are rounded toward 0",
        ("PK-07",),
        OCTAHEDRAL,
        "u, v = np.rint(u), np.rint(v)",
        "u, v = np.trunc(u), np.trunc(v)",
        ("pack-normals-toward-0",),
    ),
    Mutant(
        "v is written before u",
        (),
        OCTAHEDRAL,
        CODES,
        CODES.replace("[u, v]", "[v, u]"),
        ("v-before-u",),
    ),
    Mutant(
        "M wraps around",
        ("TR-11",),
        ROUNDING,
        COUNTED,
        "count = np.where(x > 0, np.maximum(np.rint(x), 1) % (most + 1), 0)",
        ("pack-m-wraps",),
    ),
    Mutant(
        "M below 1/2 becomes 0",
        ("SR-25",),
        ROUNDING,
        COUNTED,
        COUNTED.replace("1, most", "0, most"),
        ("pack-m-becomes-0",),
    ),
    Mutant(
        "M is written before blue",
        (),
        PAPER,
        PACKED,
        'codes["seed"] = seed\n'
        '    halves = codes.view("<u2").reshape(-1, 24)\n'
        "    halves[:, [18, 19]] = halves[:, [19, 18]]\n"
        "    return codes",
        ("m-before-blue",),
    ),
    Mutant(
        "the two normals change places",
        (),
        PAPER,
        NORMAL_THEN,
        'codes["n_v"] = encode_normal(r.y.normal)',
        ("normals-exchanged",),
        also=((PAPER, NORMAL_THERE, 'codes["n_s"] = encode_normal(n_v)'),),
    ),
]

READ_BITS = [
    Mutant(
        "infinity is read as it stands",
        ("PK-15",),
        ROUNDING,
        'return _finite(codes).astype(np.float64, order="F")',
        'return codes.astype(np.float64, order="F")',
        (),
        "robustness",
    ),
    Mutant(
        "u and v have no sign",
        ("PK-05",),
        OCTAHEDRAL,
        "codes[:, i].astype(np.int32)",
        "codes[:, i].astype(np.uint16).astype(np.int32)",
        ("unpack-without-sign",),
    ),
    Mutant(
        "normals are not normalized",
        (),
        OCTAHEDRAL,
        "return normalize(vectors(x, y, z).astype(np.float64))",
        "return vectors(x, y, z) / UNIT",
        ("unpack-not-normalized",),
    ),
    Mutant(
        "M is read with a sign",
        ("PK-05",),
        PAPER,
        'codes["M"].astype(np.float64)',
        'codes["M"].astype(np.int16).astype(np.float64)',
        ("unpack-m-with-sign",),
    ),
    Mutant(
        "blue is read first",
        (),
        PAPER,
        'radiance=widened(codes["L_o"])',
        'radiance=widened(codes["L_o"][:, ::-1])',
        ("blue-first",),
    ),
]

FURTHER_MUTANTS: tuple[Mutant, ...] = (
    *VIEW,
    *BEFORE_NOW,
    *EMPTIED,
    *TURNS,
    *PACKED_BITS,
    *READ_BITS,
)
