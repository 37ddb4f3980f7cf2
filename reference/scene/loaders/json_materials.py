"""Materials of scene.json files."""

from restir_gi.reference.scene.loaders.json_entries import JsonObject, shown
from restir_gi.reference.scene.loaders.json_words import names
from restir_gi.reference.scene.loaders.ledger import roughness
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Distribution,
    Lambertian,
    Material,
)
from restir_gi.reference.scene.textures import Color

ROUGH_METAL = ("ggx_conductor", "roughconductor", "rough_conductor")
SMOOTH_METAL = ("mirror", "conductor")
ROUGH_COAT = ("roughplastic", "rough_plastic", "ggx_plastic")
ROUGH_GLASS = ("roughdielectric", "rough_dielectric")
GLASS = (*ROUGH_GLASS, "dielectric")
KNOWN = names("material type")
MATT = Lambertian((0.5, 0.5, 0.5), two_sided=False)
WHITE = (1.0, 1.0, 1.0)


def read_material(entry: JsonObject) -> Material:
    """Material of a file; one-sided unless it says ``"twosided": true``.

    As the type says.

    Raises UsageError: the type or a key is not understood, unless lenient.

    Parameters
    ----------
    entry : JsonObject; an object with a "type"
    """
    kind = entry.get("type")
    if not isinstance(kind, str) or kind not in KNOWN:
        entry.ledger.replace(
            f"{entry.name} has the type {shown(kind)}; known are {', '.join(KNOWN)}",
            "taken as diffuse with reflectance 0.5",
        )
        return MATT
    if kind in GLASS:
        rough = kind in ROUGH_GLASS
        lobe = (_alpha(entry), _distribution(entry)) if rough else ()
        material: Material = Dielectric(_ior(entry), *lobe)
        entry.get("twosided")
    else:
        two_sided = bool(entry.get("twosided", False))
        if kind in (*ROUGH_METAL, *SMOOTH_METAL):
            material = _metal(entry, kind in ROUGH_METAL, two_sided)
        elif kind == "diffuse":
            material = Lambertian(entry.color("reflectance"), two_sided)
        else:
            material = _coat(entry, kind in ROUGH_COAT, two_sided)
    entry.refuse_unread()
    return material


def _metal(entry: JsonObject, rough: bool, two_sided: bool) -> Conductor:
    key = "reflectance" if "reflectance" in entry.raw else "specular_reflectance"
    reflectance = entry.color(key, WHITE)
    eta, k = (entry.color(x) if x in entry.raw else None for x in ("eta", "k"))
    fresnel = entry.get("fresnel")
    if fresnel is not None:
        # A constant Fresnel factor is one more factor of the reflectance.
        factor = entry.color("fresnel")
        reflectance = _product(reflectance, factor)
    if (eta is None) != (k is None) or (eta is not None and fresnel is not None):
        entry.ledger.stop(
            f"{entry.name}: its Fresnel term is eta together with k, or fresnel (a"
            " constant), or neither"
        )
    return Conductor(
        reflectance,
        alpha=_alpha(entry) if rough else 0.0,
        eta=eta,
        k=k,
        two_sided=two_sided,
        distribution=_distribution(entry) if rough else "ggx",
    )


def _coat(entry: JsonObject, rough: bool, two_sided: bool) -> Coated:
    key = "reflectance" if "reflectance" in entry.raw else "diffuse_reflectance"
    return Coated(
        entry.color(key),
        alpha=_alpha(entry) if rough else 0.0,
        ior=_ior(entry),
        nonlinear=bool(entry.get("nonlinear", False)),
        specular=entry.color("specular_reflectance", WHITE),
        two_sided=two_sided,
        distribution=_distribution(entry) if rough else "ggx",
    )


def _alpha(entry: JsonObject) -> float:
    return roughness(entry.number("alpha"), entry.name, entry.ledger)


def _distribution(entry: JsonObject) -> Distribution:
    given = entry.get("distribution", "ggx")
    known: dict[object, Distribution] = {"ggx": "ggx", "beckmann": "beckmann"}
    if not isinstance(given, str) or given not in known:
        entry.ledger.stop(
            f"{entry.name}: the distribution is {shown(given)}; it can be ggx or"
            " beckmann"
        )
    return known[given]


def _ior(entry: JsonObject) -> float:
    if "int_ior" in entry.raw:
        return entry.number("int_ior") / entry.number("ext_ior", 1.0)
    return entry.number("ior", 1.5)


def _product(a: Color, b: Color) -> Color:
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]
