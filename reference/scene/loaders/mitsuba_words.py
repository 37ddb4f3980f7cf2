"""The words of Mitsuba 3 scenes, and what becomes of each.

``element`` is a kind of plugin ("bsdf", "shape", ...) where ``name`` is a plugin, and
a plugin ("perspective", "diffuse", ...) where ``name`` is one of its parameters or the
kind of a plugin inside it.  `ANY` stands for whatever is not listed.
"""

from restir_gi.reference.scene.loaders.words import Use, Word

ANY = "any other"


def _words(element: str, use: Use, names: str, remark: str = "") -> tuple[Word, ...]:
    return tuple(Word(element, name, use, remark) for name in names.split())


def _any(element: str, use: Use, remark: str = "") -> tuple[Word, ...]:
    return (Word(element, ANY, use, remark),)


_MODELLED, _HARMLESS = Use.MODELLED, Use.HARMLESS
_REPLACED = Use.REPLACED

_ALPHA = (
    ("distribution", "beckmann (the default) or ggx"),
    ("alpha", "a number; of a texture the mean is taken under --lenient"),
    ("alpha_u", "where it equals alpha_v; else both are replaced by one of their mean"),
    ("alpha_v", "where it equals alpha_u; else both are replaced by one of their mean"),
)


def _rough(bsdf: str) -> tuple[Word, ...]:
    words = tuple(Word(bsdf, name, _MODELLED, remark) for name, remark in _ALPHA)
    return (*words, *_words(bsdf, _HARMLESS, "sample_visible"))


_ON_SHAPES = "to_world flip_normals bsdf emitter"
_COLOR = "a colour, or a texture of one"

_FILE = (
    *_words("scene", _MODELLED, "default include path ref alias"),
    *_words("scene", _MODELLED, "bsdf texture emitter shape sensor"),
    *_words(
        "scene", _HARMLESS, "integrator sampler", "the command line says what is traced"
    ),
    *_words("scene", _HARMLESS, "medium volume phase rfilter film", "if none refers"),
)
_SENSORS = (
    *_words("sensor", _MODELLED, "perspective"),
    *_words("sensor", _REPLACED, "thinlens", "taken as a pinhole"),
    *_any("sensor", _REPLACED, "ignored"),
    *_words("perspective", _MODELLED, "fov fov_axis focal_length to_world film"),
    *_words("perspective", _HARMLESS, "focus_distance", "a pinhole is always sharp"),
    *_words(
        "perspective",
        _HARMLESS,
        "near_clip far_clip",
        "as long as nothing lies before the one or behind the other",
    ),
    *_words("perspective", _HARMLESS, "shutter_open shutter_close", "nothing moves"),
    *_words("perspective", _HARMLESS, "sampler"),
    *_words(
        "perspective",
        _REPLACED,
        "principal_point_offset_x principal_point_offset_y",
        "taken as 0",
    ),
    *_words("perspective", _REPLACED, "medium", "left empty"),
    *_words("perspective", _REPLACED, "srf", "taken as that of the eye"),
    *_words("film", _MODELLED, "hdrfilm"),
    *_any("film", _REPLACED, "taken as hdrfilm"),
    *_words("hdrfilm", _MODELLED, "width height"),
    *_words("hdrfilm", _HARMLESS, "rfilter", "the command line says how pixels filter"),
    *_words("hdrfilm", _HARMLESS, "sample_border compensate banner"),
    *_words(
        "hdrfilm", _HARMLESS, "file_format pixel_format component_format", "of the file"
    ),
    *_words(
        "hdrfilm",
        _REPLACED,
        "crop_offset_x crop_offset_y crop_width crop_height",
        "the whole film taken",
    ),
)
_SHAPES = (
    *_words("shape", _MODELLED, "obj ply serialized rectangle cube sphere"),
    *_words("shape", _MODELLED, "disk cylinder", "as 128 flat facets of the same area"),
    *_words("shape", _MODELLED, "shapegroup instance merge", "as copies"),
    *_any("shape", _REPLACED, "left out"),
    *(
        word
        for kind, own in (
            ("obj", "filename face_normals flip_tex_coords"),
            ("ply", "filename face_normals flip_tex_coords"),
            ("serialized", "filename shape_index face_normals"),
            ("rectangle", ""),
            ("cube", ""),
            ("disk", ""),
            ("cylinder", "p0 p1 radius"),
            ("sphere", "center radius"),
        )
        for word in (
            *_words(kind, _MODELLED, f"{own} {_ON_SHAPES}"),
            *_words(kind, _HARMLESS, "silhouette_sampling_weight sensor"),
            *_words(kind, _REPLACED, "medium", "left empty"),
        )
    ),
    *_words("cube", _HARMLESS, "face_normals", "it is flat"),
    *_words("rectangle", _HARMLESS, "face_normals", "it is flat"),
    *_words("shapegroup", _MODELLED, "shape"),
    *_words("merge", _MODELLED, "shape"),
    *_words("instance", _MODELLED, "shape to_world"),
)
_BSDFS = (
    *_words("bsdf", _MODELLED, "diffuse conductor roughconductor plastic roughplastic"),
    *_words("bsdf", _MODELLED, "dielectric roughdielectric twosided mask"),
    *_words("bsdf", _MODELLED, "null", "the shape is left out, for it is invisible"),
    *_words(
        "bsdf",
        _REPLACED,
        "thindielectric",
        "its shape left out: a thin pane hides almost nothing",
    ),
    *_words("bsdf", _REPLACED, "polarizer retarder circular", "its shape left out"),
    *_words(
        "bsdf",
        _REPLACED,
        "blendbsdf normalmap bumpmap",
        "taken as the first BSDF inside",
    ),
    *_words(
        "bsdf",
        _REPLACED,
        "principled principledthin",
        "taken as rough metal or as a diffuse base under a coat, by its metallic",
    ),
    *_words("bsdf", _REPLACED, "pplastic", "taken as roughplastic"),
    *_any("bsdf", _REPLACED, "taken as diffuse with reflectance 0.5"),
    *_words("diffuse", _MODELLED, "reflectance", _COLOR),
    *(
        word
        for kind in ("conductor", "roughconductor")
        for word in (
            *_words(kind, _MODELLED, "material eta k"),
            *_words(kind, _MODELLED, "specular_reflectance", _COLOR),
        )
    ),
    *(
        word
        for kind in ("plastic", "roughplastic")
        for word in (
            *_words(kind, _MODELLED, "int_ior ext_ior nonlinear"),
            *_words(kind, _MODELLED, "diffuse_reflectance", _COLOR),
            *_words(kind, _MODELLED, "specular_reflectance", "a colour"),
        )
    ),
    *(
        word
        for kind in ("dielectric", "roughdielectric")
        for word in (
            *_words(kind, _MODELLED, "int_ior ext_ior"),
            *_words(
                kind,
                _REPLACED,
                "specular_reflectance specular_transmittance",
                "taken as 1",
            ),
        )
    ),
    *_rough("roughconductor"),
    *_rough("roughplastic"),
    *_rough("roughdielectric"),
    *_words("mask", _MODELLED, "bsdf"),
    *_words("mask", _MODELLED, "opacity", "0 or 1; else cut at 0.5 under --lenient"),
    *_words("twosided", _MODELLED, "bsdf", "one; of two the first under --lenient"),
)
_TEXTURES = (
    *_words("texture", _MODELLED, "bitmap checkerboard uniform srgb d65 rawconstant"),
    *_words("texture", _MODELLED, "mesh_attribute", "of a reflectance"),
    *_words("mesh_attribute", _MODELLED, "name scale"),
    *_any("texture", _REPLACED, "taken as mid grey"),
    *_words("bitmap", _MODELLED, "filename raw to_uv filter_type wrap_mode"),
    *_words("bitmap", _HARMLESS, "format accel"),
    *_words("checkerboard", _MODELLED, "color0 color1 to_uv"),
    *_words("uniform", _MODELLED, "value"),
    *_words("srgb", _MODELLED, "color"),
    *_words("d65", _MODELLED, "scale"),
    *_words("rawconstant", _MODELLED, "value"),
)
_EMITTERS = (
    *_words("emitter", _MODELLED, "area", "on a shape"),
    *_words("emitter", _MODELLED, "point spot directional constant envmap"),
    *_any("emitter", _REPLACED, "left out"),
    *_words("area", _MODELLED, "radiance", _COLOR),
    *_words("point", _MODELLED, "position to_world intensity"),
    *_words("spot", _MODELLED, "to_world intensity cutoff_angle beam_width"),
    *_words("spot", _REPLACED, "texture", "taken in its mean colour"),
    *_words("directional", _MODELLED, "direction to_world irradiance"),
    *_words("constant", _MODELLED, "radiance"),
    *_words("envmap", _MODELLED, "filename scale to_world"),
    *_words("envmap", _HARMLESS, "mis_compensation"),
    *(
        word
        for kind in ("area", "point", "spot", "directional", "constant", "envmap")
        for word in _words(kind, _HARMLESS, "sampling_weight")
    ),
)

WORDS: tuple[Word, ...] = (
    *_FILE,
    *_SENSORS,
    *_SHAPES,
    *_BSDFS,
    *_TEXTURES,
    *_EMITTERS,
)
"""All words that the loader knows."""

_BY_NAME = {(word.element, word.name): word for word in WORDS}


def find(element: str, name: str) -> Word:
    """What becomes of a word.

    That of `ANY` where there is one; else a word which is replaced by nothing.
    """
    unknown = Word(element, name, Use.REPLACED, "ignored")
    known = _BY_NAME.get((element, ANY), unknown)
    return _BY_NAME.get((element, name), known)


def modelled(element: str) -> str:
    """Names of the plugins of a kind that are modelled, separated by commas.

    Parameters
    ----------
    element : str; "bsdf", "shape", ...
    """
    names = [w.name for w in WORDS if (w.element, w.use) == (element, Use.MODELLED)]
    return ", ".join(names)
