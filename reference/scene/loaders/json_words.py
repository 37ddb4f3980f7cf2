"""Every word of scene.json, and what becomes of it.

`json_entries.Entry` hands out keys of this table alone, and refuses all others.
"""

from restir_gi.reference.scene.loaders.words import Use, Word


def _words(element: str, names: str, remark: str = "") -> tuple[Word, ...]:
    return tuple(Word(element, name, Use.MODELLED, remark) for name in names.split())


def _harmless(element: str, names: str, remark: str = "") -> tuple[Word, ...]:
    return tuple(Word(element, name, Use.HARMLESS, remark) for name in names.split())


_COAT = "of a coat or of glass"
_ANY_OTHER = "any other"

WORDS = (
    *_words("file", "name camera materials shapes lights environment"),
    Word("file", _ANY_OTHER, Use.HARMLESS, "noted"),
    *_words("camera", "origin target up fov_deg fov_axis width height"),
    *_harmless("camera", "near far near_clip far_clip", "nothing is cut off"),
    *_words("material type", "diffuse"),
    *_words("material type", "ggx_conductor roughconductor rough_conductor", "metal"),
    *_words("material type", "mirror conductor", "smooth metal"),
    *_words("material type", "roughplastic rough_plastic ggx_plastic", "rough coat"),
    *_words("material type", "plastic", "smooth coat"),
    *_words("material type", "dielectric", "smooth glass"),
    *_words("material type", "roughdielectric rough_dielectric", "rough glass"),
    Word("material type", _ANY_OTHER, Use.REPLACED, "diffuse with reflectance 0.5"),
    *_words("material", "type twosided"),
    *_words("material", "reflectance", "not of glass"),
    *_words("material", "specular_reflectance", "of metals and coats"),
    *_words("material", "diffuse_reflectance nonlinear", "of coats"),
    *_words("material", "alpha", "of what is rough"),
    *_words("material", "distribution", "ggx or beckmann, of what is rough"),
    *_words("material", "eta k", "of metals, one with the other"),
    *_words("material", "fresnel", "of metals: a constant"),
    *_words("material", "ior int_ior ext_ior", _COAT),
    *_words("shape", "material emission two_sided_emission"),
    *_words("shape", "type", '"sphere"; else the shape is a mesh'),
    *_words("shape", "file", "of a mesh: PLY or OBJ, its vertices and uv alone"),
    *_words("shape", "triangles", "of a mesh: what its file has to have"),
    *_words("shape", "center radius inward", "of a sphere"),
    *_harmless("shape", "id", "a name"),
    *_harmless("shape", "vertices area bounds bbox", "tell nothing new"),
    *_words("emission", "file scale", "a picture, where it is not a colour"),
    *_words("light type", "point spot directional constant envmap"),
    Word("light type", _ANY_OTHER, Use.REPLACED, "left out"),
    *_words("light", "type"),
    *_words("light", "position intensity", "of points and spots"),
    *_words("light", "direction", "of spots and directional lights"),
    *_words("light", "cutoff_deg beam_deg", "of spots"),
    *_words("light", "falloff", "of spots: linear or smooth"),
    *_words("light", "irradiance", "of directional lights"),
    *_words("light", "radiance", "of constant ones"),
    *_words("light", "file scale", "of an envmap"),
    *(
        Word(element, _ANY_OTHER, Use.REPLACED, "ignored; noted where it is a text")
        for element in ("camera", "material", "shape", "emission", "light")
    ),
)


def names(element: str, use: Use = Use.MODELLED) -> tuple[str, ...]:
    """Words of an element of one use, in the order of the table.

    Parameters
    ----------
    element : str; as in `WORDS`
    """
    return tuple(w.name for w in WORDS if w.element == element and w.use is use)
