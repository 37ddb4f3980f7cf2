"""Camera: a view, an image, and a free place to stand."""

import numpy as np

from restir_gi.reference.numerics.arrays import cross, dot
from restir_gi.reference.scene.camera import FOV_AXES, Camera
from restir_gi.reference.scene.checks.shapes import LARGEST
from restir_gi.reference.scene.checks.space import distance_to_triangles
from restir_gi.reference.scene.checks.values import need_numbers, refuse, told
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.origins import STEP
from restir_gi.reference.scene.scene import Scene

MOST_PIXELS = 2**28
"""Each pixel takes up to a KiB, and is numbered in 32 bits."""


def check_camera(where: str, camera: Camera) -> None:
    """Require a view that exists and an image that can be made.

    Raises UsageError, which names the property.
    """
    for name in ("position", "target"):
        need_numbers(where, name, getattr(camera, name), -LARGEST, LARGEST, count=3)
    need_numbers(where, "up", camera.up, count=3)
    view = np.subtract(camera.target, camera.position)
    if not view.any():
        shown = told(np.asarray(camera.position))
        refuse(where, f"position and target are both {shown}", "it must look somewhere")
    up = np.asarray(camera.up, float)
    if not up.any():
        refuse(where, "up is (0, 0, 0)", "it must point upwards in the image")
    view, up = view / np.abs(view).max(), up / np.abs(up).max()
    right_vector = cross(view, up)
    # Below 2⁻⁴⁰ the rounding of the cross product would turn the image.
    lengths = dot(view, view) * dot(up, up)
    if dot(right_vector, right_vector) <= 2.0**-80 * lengths:
        refuse(where, "up is parallel to the view", "it must point to the side of it")
    _check_size(where, camera)
    _check_angle(where, camera)


def _check_size(where: str, camera: Camera) -> None:
    size = f"{camera.width}x{camera.height}"
    if not all(isinstance(n, int | np.integer) for n in (camera.width, camera.height)):
        refuse(where, f"its image is {size} pixels", "use whole numbers")
    if camera.width < 1 or camera.height < 1:
        refuse(where, f"its image is {size} pixels", "use at least 1x1")
    if int(camera.width) * int(camera.height) > MOST_PIXELS:
        refuse(where, f"its image is {size} pixels", f"use at most {MOST_PIXELS}")


def _check_angle(where: str, camera: Camera) -> None:
    need_numbers(where, "fov", camera.fov)
    if not 0 < camera.fov < 180:
        right = "it must be between 0 and 180 degrees"
        refuse(where, f"fov is {camera.fov:g}", right)
    if camera.fov_axis not in FOV_AXES:
        right = f"it can be {', '.join(FOV_AXES[:-1])} or {FOV_AXES[-1]}"
        refuse(where, f"fov_axis is {camera.fov_axis!r}", right)


def check_place(where: str, scene: Scene, extent: float) -> None:
    """Require a camera that touches no surface.

    Raises UsageError, which names the shape, and the face where it is a mesh.

    Parameters
    ----------
    scene : Scene; its shapes checked
    extent : float, m; half of the longest side of the scene
    """
    eye = np.asarray(scene.camera.position, float)
    least = STEP * extent
    right = f"move it by more than {least:.2g} m"
    for mesh in scene.meshes:
        distance = distance_to_triangles(eye, world_corners(mesh))
        face = int(distance.argmin())
        if distance[face] <= least:
            refuse(where, f'it touches face {face} of mesh "{mesh.name}"', right)
    for sphere in scene.spheres:
        gap = abs(float(np.linalg.norm(eye - sphere.center)) - sphere.radius)
        if gap <= least:
            refuse(where, f'it touches sphere "{sphere.name}"', right)
