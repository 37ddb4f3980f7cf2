"""MTL files: what their surfaces scatter, reflect, refract and emit.

The format is one of 1995, of formulas for point lights without units.  `illum` says
which words count; the rest of the words has no effect.
"""

import re
from dataclasses import dataclass, field
from math import sqrt
from pathlib import PurePosixPath

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.scene.loaders.framing import color
from restir_gi.reference.scene.loaders.ledger import Ledger, roughness
from restir_gi.reference.scene.loaders.pictures import read_mask, read_picture
from restir_gi.reference.scene.loaders.words import Use, Word
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
)
from restir_gi.reference.scene.textures import Bitmap, Color, Texture
from restir_gi.reference.system.errors import UsageError

MID_GREY = (0.5, 0.5, 0.5)
BLACK = (0.0, 0.0, 0.0)
MATT, MIRROR, FRESNEL, GLASS = (0, 1), (3, 8), (5,), (4, 6, 7, 9)  # of illum
IOR = 1.5  # of a coat, where the file does not say
MOST_HIGHLIGHT = 0.9  # of what falls on a surface

WORDS = (
    Word(
        "material", "Kd", Use.MODELLED, "diffuse reflectance; else 0.8, and 0 of glass"
    ),
    Word("material", "Ke", Use.MODELLED, "radiance of the front, W/(m² sr)"),
    Word("material", "illum", Use.MODELLED, "0, 1 matt; 2, or none, with a highlight"),
    Word("material", "illum 3, 8", Use.MODELLED, "a mirror of Ks; Kd has to be 0"),
    Word("material", "illum 5", Use.MODELLED, "a smooth coat of Ni on Kd"),
    Word("material", "illum 4, 6, 7, 9", Use.MODELLED, "glass of Ni; opaque with d 1"),
    Word("material", "illum 10", Use.REPLACED, "taken as matt"),
    Word("material", "Ks", Use.MODELLED, "the highlight's height, or the mirror"),
    Word("material", "Ns", Use.MODELLED, "the highlight's exponent"),
    Word("material", "Ni", Use.MODELLED, "of glass and coats; else without effect"),
    Word("material", "d", Use.REPLACED, "taken as opaque; 1 is, and glass needs none"),
    Word("material", "Tr", Use.REPLACED, "1 - d, where there is no d"),
    Word("material", "Tf", Use.REPLACED, "clear; without effect on what is opaque"),
    Word("material", "Pr", Use.MODELLED, "roughness, alpha = Pr²; rules out illum"),
    Word("material", "Pm", Use.MODELLED, "0 or 1; taken as the nearer of them"),
    Word("material", "Ps", Use.REPLACED, "taken as 0"),
    Word("material", "Pc", Use.REPLACED, "taken as 0"),
    Word("material", "Pcr", Use.HARMLESS, "of Pc"),
    Word("material", "aniso", Use.REPLACED, "taken as 0"),
    Word("material", "anisor", Use.HARMLESS, "of aniso"),
    Word("material", "Ka", Use.HARMLESS, "ambient light, of which there is none"),
    Word("material", "map_Ka", Use.HARMLESS, "ambient light, of which there is none"),
    Word("material", "map_aat", Use.HARMLESS, "textures are as sharp as they are"),
    Word("material", "sharpness", Use.HARMLESS, "of reflection maps"),
    Word("material", "map_Kd", Use.MODELLED, "times Kd"),
    Word("material", "map_Ke", Use.MODELLED, "times Ke, where there is a Ke"),
    Word("material", "map_d", Use.MODELLED, "a mask: no surface where it is below ½"),
    Word("material", "map_Ks", Use.REPLACED, "taken as 1, where there is a highlight"),
    Word("material", "map_Ns", Use.REPLACED, "left out, where there is a highlight"),
    *(
        Word("material", name, Use.REPLACED, "left out")
        for name in (
            *("map_Pr", "map_Pm", "map_Ps", "map_Pc", "map_Tr", "bump", "map_bump"),
            *("norm", "disp", "decal", "refl"),
        )
    ),
    Word("map", "-s", Use.MODELLED, "factors on u and v, before -o"),
    Word("map", "-o", Use.MODELLED, "added to u and v"),
    Word("map", "-blendu", Use.HARMLESS, "textures are filtered in one way"),
    Word("map", "-blendv", Use.HARMLESS, "textures are filtered in one way"),
    Word("map", "-bm", Use.HARMLESS, "of bump"),
    Word("map", "-boost", Use.HARMLESS, "textures are as sharp as they are"),
    Word("map", "-texres", Use.HARMLESS, "textures are as sharp as they are"),
    Word("map", "-type", Use.HARMLESS, "of refl"),
    Word("map", "-cc", Use.REPLACED, "ignored; off is harmless"),
    Word("map", "-clamp", Use.REPLACED, "repeated; off is harmless"),
    Word("map", "-imfchan", Use.REPLACED, "ignored; l and m are harmless"),
    Word("map", "-mm", Use.REPLACED, "ignored; 0 1 is harmless"),
    Word("map", "-t", Use.REPLACED, "ignored; 0 is harmless"),
)
USES = {word.name.lower(): word.use for word in WORDS if word.element == "material"}
OPTIONS = {word.name: word.use for word in WORDS if word.element == "map"}
NUMBERED = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2}  # values at most; of others one
NEUTRAL = {
    "-cc": ("off",),
    "-clamp": ("off",),
    "-imfchan": ("l", "m"),
    "-mm": ("0 1", "0.0 1.0"),
    "-t": ("0", "0 0", "0 0 0"),
}
ZERO_IS_NONE = {"ps", "pc", "aniso"}
OF_HIGHLIGHTS = {"map_ks", "map_ns"}


@dataclass(frozen=True, slots=True, eq=False)
class MtlAppearance:
    """What a surface of a name looks like.

    Attributes
    ----------
    material : Material; how it scatters
    emission : Texture, W/(m² sr); radiance of the front
    opacity : Bitmap or None; where there is no surface
    scale, offset : (2,) float64; of the texture coordinates: scale · (u, v) + offset
    """

    material: Material
    emission: Texture = BLACK
    opacity: Bitmap | None = None
    scale: Vec3s = field(default_factory=lambda: np.ones(2))
    offset: Vec3s = field(default_factory=lambda: np.zeros(2))


PLAIN = MtlAppearance(Lambertian((0.8, 0.8, 0.8)))


def read_looks(
    libraries: tuple[str, ...], ledger: Ledger
) -> tuple[dict[str, MtlAppearance], bool]:
    """Materials of all MTL files that an OBJ file names.

    Parameters
    ----------
    libraries : tuple of str
        What stands after each mtllib: a name, which may hold spaces, or several.

    Returns
    -------
    dict of str to MtlAppearance, bool; by their names; whether all files could be read

    Raises
    ------
    UsageError
        Malformed, or (unless lenient) with something missing or not modelled.
    """
    looks: dict[str, MtlAppearance] = {}
    complete = True
    for name in dict.fromkeys(x for line in libraries for x in _names(line, ledger)):
        try:
            text = ledger.read(name).decode("utf-8-sig", "replace")
        except UsageError as error:
            ledger.replace(
                f'the material file "{name}" cannot be read ({error})',
                "all its materials taken as matt with reflectance 0.8",
            )
            complete = False
            continue
        for material in _materials(name, text, ledger):
            looks[material.name] = _look(material)
    return looks, complete


def _names(line: str, ledger: Ledger) -> list[str]:
    """One name with spaces, if there is such a file, or else several."""
    try:
        whole = ledger.has(line)
    except UsageError:
        whole = False
    return [line] if whole else line.split()


@dataclass(slots=True)
class _MtlEntry:
    """One material of a file: its words by their keys in lower case."""

    file: str
    name: str
    line: int
    ledger: Ledger
    words: dict[str, str] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)

    def where(self, key: str) -> str:
        line = self.lines.get(key, self.line)
        return f'{self.file}: line {line}: material "{self.name}"'

    def replace(self, key: str, problem: str, instead: str) -> None:
        self.ledger.replace(f"{self.where(key)}: {problem}", instead)

    def color(self, key: str, default: Color) -> Color:
        if key not in self.words:
            return default
        try:
            values = [float(word) for word in self.words[key].split()]
            return color(values * 3 if len(values) == 1 else values)
        except ValueError:
            shown = self.words[key][:60]
            self.ledger.stop(
                f'{self.where(key)}: {key} is "{shown}"; it should be one number or'
                " three"
            )

    def number(self, key: str, default: float) -> float:
        values = self.color(key, (default,) * 3)
        if values != (values[0],) * 3:
            self.ledger.stop(f"{self.where(key)}: {key} should be one number")
        return values[0]


def _materials(file: str, text: str, ledger: Ledger) -> list[_MtlEntry]:
    materials: list[_MtlEntry] = []
    for number, line in enumerate(text.splitlines(), 1):
        key, *rest = re.sub(r"(?<!\S)#.*", "", line).split(maxsplit=1)[:2] or [""]
        value = rest[0].strip() if rest else ""
        if key.lower() == "newmtl":
            materials.append(_MtlEntry(file, value, number, ledger))
        elif key and not materials:
            ledger.stop(f'{file}: line {number}: "{key}" stands before any newmtl')
        elif key:
            key = {"map_bump": "bump"}.get(key.lower(), key.lower())
            materials[-1].words[key] = value
            materials[-1].lines[key] = number
    return materials


def _look(entry: _MtlEntry) -> MtlAppearance:
    transforms: dict[str, tuple[Vec3s, Vec3s]] = {}
    grey = 0.0 if entry.number("illum", 2) in GLASS else 0.8
    factor = entry.color("kd", (grey,) * 3)
    reflectance = _textured(entry, "map_kd", factor, transforms)
    glow = (1.0,) * 3 if "map_ke" in entry.words else BLACK
    emission = _textured(entry, "map_ke", entry.color("ke", glow), transforms)
    opacity = _mask(entry, transforms)
    material = _material(entry, reflectance)
    _refuse_words(entry, bool(np.any(_highlight(entry))))
    places = list(transforms.values()) or [(np.ones(2), np.zeros(2))]
    if any(not np.array_equal(place, places[0]) for place in places):
        entry.replace(
            list(transforms)[-1],
            "its maps lie on the surface in different ways",
            f"all taken as its {next(iter(transforms))}",
        )
    return MtlAppearance(material, emission, opacity, *places[0])


def _refuse_words(entry: _MtlEntry, shines: bool) -> None:
    for key in entry.words:
        use = USES.get(key, Use.REPLACED)
        if use is not Use.REPLACED or key in ("d", "tr", "tf"):
            continue
        if key in ZERO_IS_NONE and entry.number(key, 0.0) == 0:
            continue
        if key in OF_HIGHLIGHTS and not shines:
            continue
        entry.replace(key, f'"{key}" is not modelled', "left out")


def _material(entry: _MtlEntry, reflectance: Color | Bitmap) -> Material:
    illum = entry.number("illum", 2)
    dissolved = _dissolved(entry)
    matt = isinstance(reflectance, tuple) and not any(reflectance)
    if "pr" in entry.words or "pm" in entry.words:
        _refuse_dissolved(entry, dissolved)
        return _of_roughness(entry, reflectance)
    if illum in GLASS and entry.number("ni", 1.0) != 1 and (dissolved or matt):
        return _glass(entry, matt)
    _refuse_dissolved(entry, dissolved)
    mirror = entry.color("ks", BLACK)
    if illum in (*MIRROR, *FRESNEL, *GLASS) and any(mirror):
        if illum not in FRESNEL and matt:
            return Conductor(mirror, alpha=0.0)
        if illum not in FRESNEL:
            entry.replace(
                "illum",
                f"a mirror (illum {illum:g}, Ks) over Kd is modelled with Fresnel's"
                " reflection alone (illum 5)",
                "taken as illum 5",
            )
        ior = entry.number("ni", IOR)
        return Coated(reflectance, 0.0, ior if ior > 1 else IOR, specular=mirror)
    if illum not in (*MATT, 2, *MIRROR, *FRESNEL, *GLASS):
        entry.replace("illum", f"illum {illum:g} is not modelled", "taken as matt")
    return _shining(entry, reflectance)


def _dissolved(entry: _MtlEntry) -> str:
    """Word that makes the surface less than opaque, or nothing."""
    if "d" in entry.words:
        return (
            "d"
            if entry.words["d"].split() not in (["1"], ["1.0"])
            and (entry.words["d"].startswith("-") or entry.number("d", 1.0) != 1)
            else ""
        )
    return "tr" if entry.number("tr", 0.0) != 0 else ""


def _refuse_dissolved(entry: _MtlEntry, key: str) -> None:
    if key:
        entry.replace(
            key,
            f'"{key} {entry.words[key]}" is not modelled without glass (illum 4, 6, 7'
            " or 9 with Ni)",
            "taken as opaque",
        )


def _glass(entry: _MtlEntry, black: bool) -> Material:
    if not black:
        entry.replace(
            "kd", "glass that scatters (Kd) is not modelled", "taken as clear"
        )
    if entry.color("tf", (1.0,) * 3) != (1.0,) * 3:
        entry.replace("tf", "coloured glass (Tf) is not modelled", "taken as clear")
    ior = entry.number("ni", IOR)
    if not 0 < ior < np.inf:
        entry.ledger.stop(f"{entry.where('ni')}: Ni is {ior:g}; it should be above 0")
    return Dielectric(ior)


def _of_roughness(entry: _MtlEntry, reflectance: Color | Bitmap) -> Material:
    metal = entry.number("pm", 0.0)
    if metal not in (0, 1):
        entry.replace(
            "pm", f"Pm {metal:g} is not modelled", "taken as the nearer of 0, 1"
        )
    where = f'material "{entry.name}"'
    alpha = roughness(entry.number("pr", 1.0) ** 2, where, entry.ledger)
    if metal >= 0.5:
        return Conductor(reflectance, alpha=alpha, schlick=True)
    ior = entry.number("ni", IOR)
    return Coated(reflectance, alpha=alpha, ior=ior if ior > 1 else IOR)


def _highlight(entry: _MtlEntry) -> Color:
    """Ks where illum lets it count."""
    if entry.number("illum", 2) in MATT or {"pr", "pm"} & entry.words.keys():
        return BLACK
    return entry.color("ks", BLACK)


def _shining(entry: _MtlEntry, reflectance: Color | Bitmap) -> Material:
    """Diffuse base under a coat with the highlight of the format's formula.

    Ks (N·H)^Ns / π, for light from the direction of the eye, has the width of
    Beckmann's distribution with alpha² = 2 / (Ns + 2) [Walter07], and the height of a
    coat that reflects F = 8 Ks / (Ns + 2): F D(0) / 4 = F / (4 π alpha²) = Ks / π.
    """
    ks, ns = np.array(_highlight(entry)), entry.number("ns", 0.0)
    if not ks.any():
        return Lambertian(reflectance)
    if not (ns >= 0 and (ks >= 0).all()):
        entry.ledger.stop(f"{entry.where('ks')}: Ks and Ns should not be negative")
    share = 8 * float(ks.max()) / (ns + 2)
    if not share <= MOST_HIGHLIGHT:
        entry.replace(
            "ks",
            f"its highlight reflects {share:.3g} of the light, 8 Ks / (Ns + 2); at most"
            f" {MOST_HIGHLIGHT:g} is modelled",
            "taken as matt",
        )
        return Lambertian(reflectance)
    ior = (1 + sqrt(share)) / (1 - sqrt(share))
    if ior <= 1:
        return Lambertian(reflectance)
    return Coated(
        reflectance,
        alpha=roughness(sqrt(2 / (ns + 2)), f'material "{entry.name}"', entry.ledger),
        ior=ior,
        specular=color(ks / ks.max()),
        distribution="beckmann",
    )


def _textured(
    entry: _MtlEntry,
    key: str,
    factor: Color,
    transforms: dict[str, tuple[Vec3s, Vec3s]],
) -> Color | Bitmap:
    if key not in entry.words or not any(factor):
        return factor
    name = _place(entry, key, transforms)
    try:
        pixels = read_picture(name, entry.ledger)
    except UsageError as error:
        if key == "map_ke":
            entry.replace(key, str(error), "its Ke taken alone")
            return factor
        entry.replace(key, str(error), "taken as mid grey")
        return MID_GREY
    with np.errstate(over="ignore"):  # the validation's to report
        pixels *= factor
    return Bitmap(pixels)


def _mask(
    entry: _MtlEntry, transforms: dict[str, tuple[Vec3s, Vec3s]]
) -> Bitmap | None:
    if "map_d" not in entry.words:
        return None
    try:
        return Bitmap(read_mask(_place(entry, "map_d", transforms), entry.ledger))
    except UsageError as error:
        entry.replace("map_d", str(error), "taken as opaque")
        return None


def _place(
    entry: _MtlEntry, key: str, transforms: dict[str, tuple[Vec3s, Vec3s]]
) -> str:
    """Name of a map's file from the scene's folder; how it lies is written down."""
    rest, place = entry.words[key], {"-s": np.ones(2), "-o": np.zeros(2)}
    while found := re.match(r"(-[a-z]+)\s+(.*)", rest):
        option, rest = found[1].lower(), found[2]
        values, rest = _values(option, rest)
        if option in place:
            numbers = [float(value) for value in values[:2]]
            place[option][: len(numbers)] = numbers
        elif not _is_harmless(option, values):
            shown = " ".join((option, *values))
            entry.replace(key, f'"{shown}" of {key} is not modelled', "ignored")
    transforms[key] = (place["-s"], place["-o"])
    folder = PurePosixPath(entry.file.replace("\\", "/")).parent
    return str(folder / rest.replace("\\", "/"))


def _is_harmless(option: str, values: list[str]) -> bool:
    if OPTIONS.get(option, Use.REPLACED) is Use.HARMLESS:
        return True
    return " ".join(values) in NEUTRAL.get(option, ())


def _values(option: str, rest: str) -> tuple[list[str], str]:
    """Values of an option, and what comes after them."""
    values: list[str] = []
    if option not in NUMBERED:
        value, _, rest = rest.partition(" ")
        return [value], rest.strip()
    while len(values) < NUMBERED[option]:
        found = re.match(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s+(.*)", rest)
        if not found:
            break
        values.append(found[1])
        rest = found[2]
    return values, rest
