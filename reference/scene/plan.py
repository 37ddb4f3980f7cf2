"""What is run for a scene: only what it requires."""

from dataclasses import dataclass, fields

from restir_gi.reference.scene.requirements import requirements
from restir_gi.reference.scene.scene import Scene


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Parts of the model that are run; without those that a scene does not require.

    Attributes
    ----------
    occlusion : bool
        Rays tell whether two points of surfaces see each other; else all do, unless a
        horizon parts them.
    chance : bool; a last ray looks for lights that paths may meet
    glossy : bool
        Sample points are told apart by whether they send the same radiance into all
        directions; light of those that do not is added without reuse.
    delta : bool
        Paths that leave a visible point by a delta lobe, or through a rough dielectric,
        are traced apart.
    motion : bool
        What a frame left is shifted into the next, with Jacobian, visibility and Z,
        though nothing has moved.
    """

    occlusion: bool = True
    chance: bool = True
    glossy: bool = True
    delta: bool = True
    motion: bool = True


EVERYTHING = Plan()
"""All parts, whatever the scene is."""

NEEDED_BY = {
    "occlusion": ("occlusion between points",),
    "chance": ("emitter hits",),
    "glossy": ("sample points that are not Lambertian",),
    "delta": ("delta lobes", "rough dielectrics"),
}
"""Which requirements of a scene ask for a part; none asks for motion where nothing
moves."""


def plan_of(scene: Scene) -> Plan:
    """What a scene requires.

    Parameters
    ----------
    scene : Scene; validated
    """
    needed = {r.name for r in requirements(scene)}
    asked = {part: bool(needed & set(names)) for part, names in NEEDED_BY.items()}
    return Plan(**asked, motion=False)


def everything(scene: Scene) -> Plan:
    """All parts.

    Parameters
    ----------
    scene : Scene; does not matter
    """
    return EVERYTHING


def parts() -> list[str]:
    """Names of the parts, in the order of the fields of `Plan`."""
    return [field.name for field in fields(Plan)]
