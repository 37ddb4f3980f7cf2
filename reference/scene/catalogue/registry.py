"""The built-in scenes by name."""

from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches

from reference.errors import UsageError
from reference.scene.catalogue import rooms, spheres, walls
from reference.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Entry:
    """A built-in scene.

    Attributes
    ----------
    name : str
        As on the command line.
    build : callable
        Makes the scene.
    summary : str
        What it shows.
    answer : str or None
        What is known of its picture in closed form, see
        :mod:`reference.scene.catalogue.answers`.
    """

    name: str
    build: Callable[[], Scene]
    summary: str
    answer: str | None = None


_ENTRIES = (
    Entry(
        "cornell-box",
        rooms.cornell_box,
        "colours of two walls bleed onto two white blocks",
    ),
    Entry(
        "door-ajar",
        rooms.door_ajar,
        "hard: a room lit only through the gap of a door",
    ),
    Entry(
        "sunlit-wall",
        walls.sunlit_wall,
        "a sunlit wall lights the floor before it, as Figure 7 of the paper",
        "floor, 1 bounce: reflectances times E/pi times the wall's form factor",
    ),
    Entry(
        "glossy-floor",
        walls.glossy_floor,
        "shadows and reflections of thin legs, as Figure 9 of the paper",
    ),
    Entry(
        "grazing-light",
        walls.grazing_light,
        "all light comes from near the floor's horizon, as Figure 14 of the paper",
    ),
    Entry(
        "sphere-furnace",
        spheres.sphere_furnace,
        "inside a sphere that glows evenly: no noise at all",
        "all pixels, k bounces: emission times the sum of albedo^i, i = 2 to k + 1",
    ),
    Entry(
        "half-lit-sphere",
        spheres.half_lit_sphere,
        "inside a sphere, half grey and half black: M times the picture is an integer",
        "all pixels, 1 bounce: albedo^2 I/pi times n/M, n ~ Binomial(M, 1/2)",
    ),
    Entry(
        "parallel-plates",
        walls.parallel_plates,
        "a sunlit plate lights the one below it",
        "lower plate, 1 bounce: reflectances times E/pi times the upper form factor",
    ),
    Entry(
        "checker",
        walls.checker,
        "checkered floor and wall and a block under an even sky",
    ),
    Entry(
        "many-lights",
        rooms.many_lights,
        "a hall under 30,000 small coloured lamps",
    ),
)

CATALOGUE: dict[str, Entry] = {entry.name: entry for entry in _ENTRIES}
"""All built-in scenes, by name."""


def find_scene(name: str) -> Scene:
    """Built-in scene of a name.

    Parameters
    ----------
    name : str
        As in the catalogue.

    Returns
    -------
    Scene
        Freshly built.

    Raises
    ------
    UsageError
        No scene has that name; the message says which do, the closest one first.
    """
    if name in CATALOGUE:
        return CATALOGUE[name].build()
    close = get_close_matches(name, CATALOGUE, n=1)
    hint = f"did you mean {close[0]}? " if close else ""
    every = ", ".join(CATALOGUE)
    raise UsageError(f"there is no scene {name!r}; {hint}the scenes are {every}")
