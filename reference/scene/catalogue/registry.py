"""The built-in scenes by name."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from restir_gi.reference.scene.animation import Animation, still
from restir_gi.reference.scene.catalogue import (
    animations,
    market,
    rooms,
    shaft,
    speculars,
    spheres,
    walls,
)
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown


@dataclass(frozen=True, slots=True)
class CatalogueScene:
    """A built-in scene.

    Attributes
    ----------
    build : callable; makes the scene
    answer : str or None
        What is known of its picture in closed form, see
        :mod:`restir_gi.reference.scene.catalogue.answers`.
    animate : callable or None
        Frames of the scene, which is their frame 0; ``None`` where it stands still.
    """

    name: str
    build: Callable[[], Scene]
    summary: str
    answer: str | None = None
    animate: Callable[[Scene], Animation] | None = None


def _cornell_box(name: str) -> Callable[[], Scene]:
    def build() -> Scene:
        """The Cornell box, by the name of its animation."""
        return replace(rooms.cornell_box(), name=name)

    return build


_ENTRIES = (
    CatalogueScene(
        "cornell-box",
        rooms.cornell_box,
        "colours of two walls bleed onto two white blocks",
    ),
    CatalogueScene(
        "door-ajar",
        rooms.door_ajar,
        "hard: a room lit only through the gap of a door",
    ),
    CatalogueScene(
        "sunlit-wall",
        walls.sunlit_wall,
        "a sunlit wall lights the floor before it, as Figure 7 of the paper",
        "floor, 1 bounce: reflectances times E/pi times the wall's form factor",
    ),
    CatalogueScene(
        "glossy-floor",
        walls.glossy_floor,
        "shadows and reflections of thin legs, as Figure 9 of the paper",
    ),
    CatalogueScene(
        "grazing-light",
        walls.grazing_light,
        "all light comes from near the floor's horizon, as Figure 14 of the paper",
    ),
    CatalogueScene(
        "sphere-furnace",
        spheres.sphere_furnace,
        "inside a sphere that glows evenly: no noise at all",
        "all pixels, k bounces: emission times the sum of albedo^i, i = 2 to k + 1",
    ),
    CatalogueScene(
        "half-lit-sphere",
        spheres.half_lit_sphere,
        "inside a sphere, half grey and half black: M times the picture is an integer",
        "all pixels, 1 bounce: albedo^2 I/pi times n/M, n ~ Binomial(M, 1/2)",
    ),
    CatalogueScene(
        "parallel-plates",
        walls.parallel_plates,
        "a sunlit plate lights the one below it",
        "lower plate, 1 bounce: reflectances times E/pi times the upper form factor",
    ),
    CatalogueScene(
        "checker",
        walls.checker,
        "checkered floor and wall and a block under an even sky",
    ),
    CatalogueScene(
        "many-lights",
        rooms.many_lights,
        "a hall under 30,000 small coloured lamps",
    ),
    CatalogueScene(
        "night-market",
        market.night_market,
        "900 stalls under 30,000 lamps, of which each place sees a few",
    ),
    CatalogueScene(
        "shaft",
        shaft.shaft,
        "hard: a room lit only from the top of a tall shaft",
    ),
    CatalogueScene(
        "specular-floor",
        speculars.specular_floor,
        "a polished floor mirrors a ceiling that only a lit spot of the floor lights",
    ),
    CatalogueScene(
        "mirror-floor",
        speculars.mirror_floor,
        "a room on a mirror, which light passes too",
    ),
    CatalogueScene(
        "glass-floor",
        speculars.glass_floor,
        "a room on a pane of glass over a diffuse ground",
    ),
    CatalogueScene(
        "moving-camera",
        _cornell_box("moving-camera"),
        "the Cornell box from a camera that flies and turns",
        animate=animations.moving_camera,
    ),
    CatalogueScene(
        "moving-block",
        _cornell_box("moving-block"),
        "the Cornell box whose short block slides and turns",
        animate=animations.moving_block,
    ),
    CatalogueScene(
        "moving-light",
        _cornell_box("moving-light"),
        "the Cornell box whose light travels under the ceiling",
        animate=animations.moving_light,
    ),
    CatalogueScene(
        "light-switch",
        _cornell_box("light-switch"),
        "the Cornell box whose light goes out at frame 16",
        animate=animations.light_switch,
    ),
    CatalogueScene(
        "sunlight-turns",
        animations.sunlit_room,
        "the sun turns suddenly at frame 16, as in Figure 11 of the paper",
        animate=animations.sunlight_turns,
    ),
)

CATALOGUE: dict[str, CatalogueScene] = {entry.name: entry for entry in _ENTRIES}
"""All built-in scenes, by name."""


def find_scene(name: str) -> Scene:
    """Built-in scene of a name, freshly built; frame 0 of one that is animated.

    Raises UsageError: no scene has that name; the message says which do, the closest
    one first.
    """
    return _entry(name).build()


def find_animation(name: str, scene: Scene | None = None) -> Animation:
    """Frames of the built-in scene of a name.

    The same scene in every frame, where it stands still.

    Raises UsageError: no scene has that name.

    Parameters
    ----------
    scene : Scene, optional
        That scene with another size of picture, say; by default as `find_scene` gives
        it.
    """
    entry = _entry(name)
    scene = scene or entry.build()
    return entry.animate(scene) if entry.animate else still(scene)


def _entry(name: str) -> CatalogueScene:
    if name in CATALOGUE:
        return CATALOGUE[name]
    raise UsageError(unknown("scene", name, CATALOGUE))
