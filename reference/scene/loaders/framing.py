"""Cameras and lights for files that have none, and the axis of the angle of view."""

from collections.abc import Sequence

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.scene.camera import FOV_AXES, Camera, FovAxis
from restir_gi.reference.scene.lights import ConstantEnvironment
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere, emits
from restir_gi.reference.scene.textures import Color

FOV = 45.0  # degrees
VIEW = (1.0, 0.75, 1.5)  # towards the eye: from the right, above, in front


def color(values: Sequence[float] | Vec3s) -> Color:
    """Three numbers of any kind as a colour or a point.

    Parameters
    ----------
    values : (3,) float; any sequence

    Raises
    ------
    ValueError
        Not three numbers.
    """
    x, y, z = (float(value) for value in values)
    return x, y, z


def fov_axis(where: str, word: object, ledger: Ledger) -> FovAxis:
    """Axis of the angle of view that a file names.

    Raises UsageError: there is no such axis.
    """
    named = [axis for axis in FOV_AXES if axis == word]
    if not named:
        known = f"{', '.join(FOV_AXES[:-1])} or {FOV_AXES[-1]}"
        ledger.stop(f"{where}: fov_axis is {word!r}; it can be {known}")
    return named[0]


def framing_camera(meshes: Sequence[Mesh], spheres: Sequence[Sphere]) -> Camera:
    """Camera that sees all shapes from the front, right and above.

    Parameters
    ----------
    meshes : sequence of Mesh; in the world (their poses are the identity)
    spheres : sequence of Sphere; in the world

    Returns
    -------
    Camera
        Square, y up; its image contains the sphere about the bounding box, at any
        size.
    """
    corners = [mesh.vertices for mesh in meshes]
    # Numbers that are not finite are the validation's to report.
    with np.errstate(invalid="ignore", over="ignore"):
        for sphere in spheres:
            center = np.array(sphere.center)
            corners.append(np.array([center - sphere.radius, center + sphere.radius]))
    points = np.concatenate([np.zeros((0, 3)), *corners])
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        points = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    low, high = points.min(axis=0), points.max(axis=0)
    center = low / 2 + high / 2
    with np.errstate(over="ignore"):  # the validation's to report
        radius = float(np.linalg.norm(high - low)) / 2 or 1.0
    direction = np.array(VIEW) / np.linalg.norm(VIEW)
    distance = radius / np.sin(np.radians(FOV) / 2)
    return Camera(
        position=color(center + distance * direction),
        target=color(center),
        fov=FOV,
        fov_axis="smaller",
    )


def camera_or_framing(
    camera: Camera | None,
    meshes: Sequence[Mesh],
    spheres: Sequence[Sphere],
    ledger: Ledger,
) -> Camera:
    """Camera of the file, or else one that frames the scene, noted.

    Parameters
    ----------
    meshes : sequence of Mesh; in the world
    spheres : sequence of Sphere; in the world
    """
    if camera is not None:
        return camera
    ledger.note(
        "The file has no camera: it is seen from the right, above and in front (y up),"
        f" as a whole, with an angle of view of {FOV:g} degrees, 256x256"
    )
    return framing_camera(meshes, spheres)


def default_environment(scene: Scene, ledger: Ledger) -> ConstantEnvironment | None:
    """Light for a file that has none, noted, of radiance 1, unless something emits.

    Parameters
    ----------
    scene : Scene; without an environment
    """
    glows = any(map(emits, scene.meshes)) or any(map(emits, scene.spheres))
    if scene.lamps or scene.suns or glows:
        return None
    ledger.note(
        "Nothing in the file emits light: a constant environment of radiance 1"
        " surrounds the scene"
    )
    return ConstantEnvironment((1.0, 1.0, 1.0))
