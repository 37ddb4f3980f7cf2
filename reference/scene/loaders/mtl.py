"""MTL files: the part of them that a matt, glowing surface needs."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from reference.errors import UsageError
from reference.files import read_file
from reference.scene.loaders.framing import color
from reference.scene.loaders.ledger import Ledger
from reference.scene.loaders.pictures import read_picture
from reference.scene.materials.kinds import Lambertian
from reference.scene.textures import Bitmap, Color, Texture

MID_GREY = (0.5, 0.5, 0.5)
# Not about light that a surface scatters or emits: the ambient term, and the recipe.
WITHOUT_EFFECT = {"ka", "illum"}


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """What a surface of a name looks like.

    Attributes
    ----------
    material : Lambertian
        How it scatters.
    emission : Texture, W/(m² sr)
        Radiance of the front.
    """

    material: Lambertian
    emission: Texture = (0.0, 0.0, 0.0)


PLAIN = Look(Lambertian((0.8, 0.8, 0.8)))


def read_looks(path: Path, ledger: Ledger) -> dict[str, Look]:
    """Materials of all MTL files that an OBJ file names.

    Parameters
    ----------
    path : Path
        The OBJ file.
    ledger : Ledger
        Of it.

    Returns
    -------
    dict of str to Look
        By their names.

    Raises
    ------
    UsageError
        Malformed, or (unless lenient) a file missing.
    """
    text = read_file(path).decode("utf-8", "replace")
    looks: dict[str, Look] = {}
    for name in re.findall(r"^[ \t]*mtllib[ \t]+(.*?)[ \t\r]*$", text, re.MULTILINE):
        try:
            lines = ledger.read(name).decode("utf-8", "replace")
        except UsageError as error:
            ledger.replace(
                f'the material file "{name}" cannot be read ({error})',
                "all its materials taken as matt with reflectance 0.8",
            )
            continue
        own = Ledger(
            path.parent / name,
            ledger.lenient,
            ledger.allow_outside,
            ledger.notes,
            ledger.refusals,
        )
        with own.reading("MTL file"):
            for material, entries in _materials(lines):
                looks[material] = _look(material, entries, own)
    return looks


def _materials(text: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Name and entries of each material, keys in lower case."""
    for block in re.split(r"^[ \t]*newmtl[ \t]+", text, flags=re.MULTILINE)[1:]:
        name, *lines = block.splitlines()
        pairs = (line.split(maxsplit=1) for line in lines if not line.startswith("#"))
        yield name.strip(), {p[0].lower(): p[1].strip() for p in pairs if len(p) == 2}


def _look(name: str, entries: dict[str, str], ledger: Ledger) -> Look:
    known = {"kd", "ke", "map_kd", "map_ke"}
    if ignored := sorted(entries.keys() - known - WITHOUT_EFFECT):
        ledger.note(
            f'material "{name}" of {ledger.path.name}: {", ".join(ignored)} ignored, it'
            " is matt and opaque"
        )
    factor = _numbers(entries.get("kd", "0.8"))
    reflectance: Color | Bitmap = factor
    if "map_kd" in entries:
        instead = "taken as mid grey"
        read = _texture(name, entries["map_kd"], factor, instead, ledger)
        reflectance = read or MID_GREY
    glows = "map_ke" in entries
    radiance = _numbers(entries.get("ke", "1" if glows else "0"))
    emission: Color | Bitmap = radiance
    if glows:
        instead = "its Ke taken alone"
        read = _texture(name, entries["map_ke"], radiance, instead, ledger)
        emission = read or radiance
    return Look(Lambertian(reflectance), emission)


def _numbers(text: str) -> Color:
    values = [float(word) for word in text.split()]
    return color(values * 3 if len(values) == 1 else values)


def _texture(
    name: str, text: str, factor: Color, instead: str, ledger: Ledger
) -> Bitmap | None:
    if text.startswith("-"):
        ledger.replace(
            f'material "{name}": the options of the map "{text}" are not understood;'
            " a file name alone is",
            "ignored",
        )
        text = text.split()[-1]
    try:
        pixels = read_picture(text, ledger)
    except UsageError as error:
        ledger.replace(f'{ledger.path.name}: material "{name}": {error}', instead)
        return None
    return Bitmap(pixels * factor)
