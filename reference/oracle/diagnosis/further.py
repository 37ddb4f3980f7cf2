"""Known mistakes in the passes that stand around the resampling of a frame."""

from restir_gi.reference.oracle.diagnosis.further_filters import FILTERS
from restir_gi.reference.oracle.diagnosis.further_layouts import LAYOUT_MISTAKES
from restir_gi.reference.oracle.diagnosis.further_packing import PACKING
from restir_gi.reference.oracle.diagnosis.further_turns import TURNS
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis, mistake
from restir_gi.reference.oracle.replay.further.rules import FurtherRules

GBUFFER, REPROJECT = ("gbuffer",), ("reproject",)
VIEW = (*GBUFFER, *REPROJECT)

X_RIGHT = "x = pixel mod width + 1/2, y = ⌊pixel / width⌋ + 1/2"
RISE_RIGHT = "d = … + (height − 2y) / width h upward + …"
SIMILAR_RIGHT = "n·n_row ≥ cos(max_angle) and |z − z_row| ≤ max_depth · max(z, z_row)"
ROW_RIGHT = "row = ⌊y⌋ · width + ⌊x⌋"
INSIDE_RIGHT = "row = −1 but where 0 ≤ x < width and 0 ≤ y < height"

CAMERAS = (
    mistake(
        "pixel-corner",
        "rays go through the corners of pixels",
        "x = pixel mod width, y = ⌊pixel / width⌋",
        X_RIGHT,
        GBUFFER,
        part=FurtherRules(pixel_place=0.0),
    ),
    mistake(
        "image-upside-down",
        "y of the image counts upwards",
        "d = … + (2y − height) / width h upward + …",
        RISE_RIGHT,
        VIEW,
        part=FurtherRules(upside_down=True),
    ),
    mistake(
        "image-mirrored",
        "the frame of the camera is of the other hand",
        "right = (up × forward) / |up × forward|, upward = forward × right",
        "right = (forward × up) / |forward × up|, upward = right × forward",
        VIEW,
        part=FurtherRules(mirrored=True),
    ),
    mistake(
        "angle-of-the-height",
        "the horizontal angle of view is taken for the vertical one",
        "h = tan(fov_x / 2) · width / height",
        "h = tan(fov_x / 2)",
        VIEW,
        part=FurtherRules(angle_of_height=True),
    ),
    mistake(
        "up-as-it-is",
        "the vector up is taken for the upward axis",
        "upward = up",
        "upward = right × forward",
        VIEW,
        part=FurtherRules(up_as_it_is=True),
    ),
    mistake(
        "distance-for-depth",
        "the depth is the distance from the pinhole",
        "z = |p − eye|",
        "z = forward · (p − eye)",
        VIEW,
        part=FurtherRules(depth_is_distance=True),
    ),
    mistake(
        "behind-the-camera",
        "what lies behind the pinhole is seen",
        "hit where t < 0 too; row of |z|",
        "hit where t > 0; row = −1 where z ≤ 0",
        VIEW,
        part=FurtherRules(behind_counts=True),
    ),
    mistake(
        "normal-not-turned",
        "the normal stays on the side that the triangle was wound for",
        "normal = n / |n|",
        "normal = n / |n|, or its negative where n·d > 0",
        GBUFFER,
        part=FurtherRules(normal_turns=False),
    ),
    mistake(
        "back-faces-not-met",
        "triangles are met from one side alone",
        "hit where n·d < 0 and t > 0 …",
        "hit where t > 0 …",
        GBUFFER,
        part=FurtherRules(back_faces=False),
    ),
)

PLACES = (
    mistake(
        "place-rounded",
        "the place before is rounded, not cut off",
        "row = [y] · width + [x]",
        ROW_RIGHT,
        REPROJECT,
        part=FurtherRules(place_shift=0.5),
    ),
    mistake(
        "place-half-a-pixel-aside",
        "pixels have their centres at whole numbers",
        "row = ⌊y − 1/2⌋ · width + ⌊x − 1/2⌋",
        ROW_RIGHT,
        REPROJECT,
        part=FurtherRules(place_shift=-0.5),
    ),
    mistake(
        "place-truncated",
        "the place before is cut off toward 0, so that two pixels' width counts as one",
        "row = int(y) · width + int(x), with int(−0.9) = 0",
        ROW_RIGHT,
        REPROJECT,
        "kajiya e8bc912",
        "bevy cbfaae46da",
        part=FurtherRules(border="truncated"),
    ),
    mistake(
        "place-clamped",
        "places outside of the image are moved to its border",
        "x = clamp(x, 0, width − 1), y = clamp(y, 0, height − 1)",
        INSIDE_RIGHT,
        REPROJECT,
        part=FurtherRules(border="clamped"),
    ),
    mistake(
        "place-beyond-the-border",
        "the column after the last is inside of the image",
        "row = −1 where x > width",
        INSIDE_RIGHT,
        REPROJECT,
        "RTXDI, `any(pixel > viewport)`",
        part=FurtherRules(border="wide"),
    ),
    mistake(
        "own-pixel-tested",
        "the tests look at the pixel itself, not at the place before",
        "n_row and z_row of the row of now",
        "n_row and z_row of row",
        REPROJECT,
        part=FurtherRules(own_normal_asked=True, own_depth_asked=True),
    ),
    mistake(
        "own-depth-tested",
        "the depth is compared with that of the pixel itself, the normal is not",
        "z_row of the row of now",
        "z_row of row",
        REPROJECT,
        part=FurtherRules(own_depth_asked=True),
    ),
    mistake(
        "normals-not-tested",
        "normals are not compared with those of the last frame",
        "|z − z_row| ≤ max_depth · max(z, z_row)",
        SIMILAR_RIGHT,
        REPROJECT,
        part=FurtherRules(compares_normals=False),
    ),
    mistake(
        "similarity-not-tested",
        "nothing is compared with the last frame",
        "row is taken wherever it is in the image",
        SIMILAR_RIGHT,
        REPROJECT,
        part=FurtherRules(compares_anything=False),
    ),
    mistake(
        "place-depth-relative-to-own",
        "the depth test is relative to the depth of the point alone",
        "|z − z_row| ≤ max_depth · z",
        "|z − z_row| ≤ max_depth · max(z, z_row)",
        REPROJECT,
        depth_test="own",
    ),
    mistake(
        "misses-go-on",
        "pixels that see nothing have a row of the last frame",
        "row, whatever hit is",
        "row = −1 where hit is 0",
        REPROJECT,
        part=FurtherRules(misses_go_on=True),
    ),
)

FURTHER_MISTAKES: tuple[Hypothesis, ...] = (
    *CAMERAS,
    *PLACES,
    *FILTERS,
    *TURNS,
    *PACKING,
    *LAYOUT_MISTAKES,
)
