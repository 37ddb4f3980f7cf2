"""A scene: everything that light meets, and the eye."""

from dataclasses import dataclass

from reference.scene.camera import Camera
from reference.scene.lights import (
    DirectionalLight,
    Environment,
    Lamp,
    PointLight,
    SpotLight,
)
from reference.scene.shapes import Mesh, Sphere


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """Everything that light meets, and the eye.

    Attributes
    ----------
    name : str
        For messages and file headers.
    camera : Camera
        The eye.
    meshes : tuple of Mesh
        Triangles.
    spheres : tuple of Sphere
        Analytic spheres.
    points : tuple of PointLight
        Point lights.
    spots : tuple of SpotLight
        Spot lights.
    suns : tuple of DirectionalLight
        Directional lights.
    environment : Environment or None
        What rays see that leave the scene; ``None`` is black.
    notes : tuple of str
        What a loader dropped or replaced, a sentence each.
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
