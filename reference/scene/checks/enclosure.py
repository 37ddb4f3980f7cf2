"""A camera shut up in the dark: inside a closed opaque shape without a light."""

from collections.abc import Iterator

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.scene.checks.balls import Ball
from restir_gi.reference.scene.checks.shells import Shell, closed_shells
from restir_gi.reference.scene.checks.space import sees_out
from restir_gi.reference.scene.checks.values import refuse
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.materials.kinds import Dielectric
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere, emits

Region = Shell | Ball


def check_enclosure(where: str, scene: Scene) -> None:
    """Require a camera that is not in a closed opaque shape which holds no light.

    Raises UsageError, which names the shape.  Certain: a room that holds a lamp, that
    glows inside or that rounding leaves in doubt passes, and so does glass.

    Parameters
    ----------
    scene : Scene; its shapes checked
    """
    eye = np.asarray(scene.camera.position, float)
    for shape, region in _around(eye, scene):
        if not _may_hold_light(region, shape, scene):
            kind = "mesh" if isinstance(shape, Mesh) else "sphere"
            wrong = f'it is inside {kind} "{shape.name}"'
            right = "that is closed, opaque and dark inside: move it out, or add a lamp"
            refuse(where, wrong, right)


def _around(eye: Vec3s, scene: Scene) -> Iterator[tuple[Mesh | Sphere, Region]]:
    """Closed opaque parts of shapes that certainly hold the eye."""
    for mesh in scene.meshes:
        corners = world_corners(mesh)
        pervious = isinstance(mesh.material, Dielectric) or mesh.opacity is not None
        if pervious or sees_out(eye, corners):
            continue
        for shell in closed_shells(mesh.faces, mesh.vertices, corners):
            if shell.holds(eye):
                yield mesh, shell
    for sphere in scene.spheres:
        ball = Ball(np.asarray(sphere.center), sphere.radius, not sphere.inward)
        if not isinstance(sphere.material, Dielectric) and ball.holds(eye):
            yield sphere, ball


def _may_hold_light(region: Region, shell_of: Mesh | Sphere, scene: Scene) -> bool:
    lamps: list[Vec3s] = [np.asarray(lamp.position) for lamp in scene.lamps]
    if not all(region.excludes_point(lamp) for lamp in lamps):
        return True
    inside_emits = shell_of.two_sided_emission or not region.outward
    if emits(shell_of) and inside_emits:
        return True
    for mesh in scene.meshes:
        if emits(mesh):
            corners = world_corners(mesh)
            if mesh is shell_of and isinstance(region, Shell):
                corners = np.delete(corners, region.faces, axis=0)
            if not region.excludes_triangles(corners):
                return True
    return any(
        emits(sphere)
        and sphere is not shell_of
        and not region.excludes_sphere(np.asarray(sphere.center), sphere.radius)
        for sphere in scene.spheres
    )
