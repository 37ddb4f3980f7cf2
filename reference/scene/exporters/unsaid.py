"""What neither form of file is written with."""

from collections.abc import Iterator

from restir_gi.reference.scene.exporters.triangles import (
    faces_against_normals,
    in_world,
)
from restir_gi.reference.scene.lights import LatLongEnvironment
from restir_gi.reference.scene.materials.kinds import Dielectric
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere
from restir_gi.reference.scene.textures import Bitmap, Pattern


def unsaid_in_both(scene: Scene) -> Iterator[str]:
    """What no form is written with here, a clause each.

    No built-in scene has any of it: a scene that comes to have it is refused, and not
    written without it.
    """
    if scene.spots:
        yield "it has a spot light, which is not exported"
    if isinstance(scene.environment, LatLongEnvironment):
        yield "it has an environment map, which is not exported"
    for mesh in scene.meshes:
        where = f'"{mesh.name}"'
        if mesh.colors is not None:
            yield f"{where} has vertex colours, which are not exported"
        if mesh.opacity is not None:
            yield f"{where} has a mask, which is not exported"
        if faces_against_normals(in_world(mesh)):
            yield f"{where} has vertex normals on the back of a face, which files turn"
        yield from _pictures(mesh, where)
    for sphere in scene.spheres:
        yield from _pictures(sphere, f'"{sphere.name}"')


def _pictures(shape: Mesh | Sphere, where: str) -> Iterator[str]:
    material = shape.material
    if isinstance(shape.emission, Pattern):
        yield f"{where} has a texture of radiance, which is not exported"
    if not isinstance(material, Dielectric) and isinstance(
        material.reflectance, Bitmap
    ):
        yield f"{where} has a picture as its texture, which is not exported"
