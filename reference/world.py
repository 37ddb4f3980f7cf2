"""A scene made ready for rays: primitives, accelerator and lights."""

from dataclasses import dataclass

from reference.caster import RayCaster
from reference.scene.camera import Camera
from reference.scene.emitters import Emitters, build_emitters
from reference.scene.geometry import Geometry, build_geometry
from reference.scene.materials.parameters import MaterialTable
from reference.scene.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A scene made ready for rays.

    Attributes
    ----------
    camera : Camera
        The eye.
    geometry : Geometry
        Primitives and materials.
    caster : RayCaster
        Traces rays, and counts them.
    emitters : Emitters or None
        Lights; ``None`` where nothing emits.
    """

    camera: Camera
    geometry: Geometry
    caster: RayCaster
    emitters: Emitters | None

    @property
    def materials(self) -> MaterialTable:
        """Materials of the scene."""
        return self.geometry.materials


def build_world(scene: Scene) -> World:
    """Make a scene ready for rays.

    Parameters
    ----------
    scene : Scene
        Validated by :func:`reference.scene.validation.validate`.

    Returns
    -------
    World
        With a camera of the size that the scene asks for.
    """
    geometry = build_geometry(scene)
    caster = RayCaster(geometry)
    emitters = build_emitters(scene, geometry)
    return World(scene.camera, geometry, caster, emitters)
