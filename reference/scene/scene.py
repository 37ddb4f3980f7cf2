"""A scene: everything that light meets, and the eye."""

from dataclasses import dataclass

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.lights import (
    DirectionalLight,
    Environment,
    Lamp,
    PointLight,
    SpotLight,
)
from restir_gi.reference.scene.shapes import Mesh, Sphere


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """Everything that light meets, and the eye.

    Attributes
    ----------
    name : str; for messages and file headers
    environment : Environment or None
        What rays see that leave the scene; ``None`` is black.
    notes : tuple of str; what a loader dropped or replaced, a sentence each
    """

    name: str
    camera: Camera
    meshes: tuple[Mesh, ...] = ()
    spheres: tuple[Sphere, ...] = ()
    points: tuple[PointLight, ...] = ()
    spots: tuple[SpotLight, ...] = ()
    suns: tuple[DirectionalLight, ...] = ()
    environment: Environment | None = None
    notes: tuple[str, ...] = ()

    @property
    def lamps(self) -> tuple[Lamp, ...]:
        """Point lights, then spot lights: what shines from a single point."""
        return *self.points, *self.spots
