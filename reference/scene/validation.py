"""Whether a scene can be rendered, and if not, why: one line."""

import numpy as np

from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.checks.camera import check_camera, check_place
from restir_gi.reference.scene.checks.enclosure import check_enclosure
from restir_gi.reference.scene.checks.lights import check_lights, check_lit, is_lit
from restir_gi.reference.scene.checks.shapes import (
    check_mesh,
    check_sphere,
    without_flat_faces,
)
from restir_gi.reference.scene.checks.values import refuse
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.motion import motion_between
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.system.errors import UsageError

SMALLEST = 1e-50
"""Half of the longest side of a scene, in metres, whose square still has a square."""

REMOTEST = 2.0**30
"""Distance from the origin in half extents, up to which float64 resolves a scene.

Its rounding there is 2⁻²³ of the scene, a sixteenth of the step before a surface from
which rays start.
"""


def validate(scene: Scene, may_be_dark: bool = False) -> Scene:
    """Scene that can be rendered: every number has a meaning, and light can be seen.

    Everything that renders takes a validated scene and checks nothing again.

    The same without triangles that have no area; its notes count them.

    Raises UsageError: what is wrong, in which shape and where in it, and what would be
    right.

    Parameters
    ----------
    scene : Scene; as an author or a loader gives it
    may_be_dark : bool
        Let pass a scene in which no light shines: in an animation lights may go out.
    """
    for mesh in scene.meshes:
        check_mesh(f'{scene.name}: mesh "{mesh.name}"', mesh)
    for sphere in scene.spheres:
        check_sphere(f'{scene.name}: sphere "{sphere.name}"', sphere)
    scene = without_flat_faces(scene)
    extent = check_extent(scene)
    check_lights(scene)
    if not may_be_dark:
        check_lit(scene)
    where = f"{scene.name}: camera"
    check_camera(where, scene.camera)
    check_place(where, scene, extent)
    if is_lit(scene):
        check_enclosure(where, scene)
    return scene


def validate_frames(animation: Animation) -> Animation:
    """Animation whose every frame is validated before it is handed out.

    Only frame 0 must be lit.  All frames must have its triangles, moved rigidly, and
    its size of picture.

    The very scenes of ``animation``.  A scene that stays the same object is validated
    once, and one that stands still not again.

    Raises UsageError when a frame is asked for: what is wrong with it, and which frame
    it is.

    Parameters
    ----------
    animation : Animation; of a scene that :func:`validate` has passed
    """
    if animation.changes == "nothing":
        return animation
    first = animation(0)
    passed: list[Scene] = []

    def at(frame: int) -> Scene:
        scene = animation(frame)
        if not any(scene is one for one in passed):
            try:
                _check_frame(first, scene, may_be_dark=frame > 0)
            except UsageError as error:
                raise UsageError(f"frame {frame} of {error}") from None
            passed[:] = [scene]
        return scene

    return Animation(at, animation.changes)


def _check_frame(first: Scene, scene: Scene, may_be_dark: bool) -> None:
    if validate(scene, may_be_dark) is not scene:
        right = "validate the scene before it is animated"
        refuse(scene.name, "it has triangles without area", right)
    motion_between(first, scene)
    was, now = first.camera, scene.camera
    if (was.width, was.height) != (now.width, now.height):
        wrong = f"its image is {now.width}x{now.height} pixels"
        refuse(scene.name, wrong, f"use {was.width}x{was.height}, as in frame 0")


def check_extent(scene: Scene) -> float:
    """Require a scene that has a size, and lies where numbers resolve it.

    Raises UsageError: there is no shape, or the scene is too small or too far out.

    Parameters
    ----------
    scene : Scene; its shapes checked, without flat triangles

    Returns
    -------
    float, m; half of the longest side of its bounding box
    """
    boxes = [world_corners(mesh).reshape(-1, 3) for mesh in scene.meshes]
    for sphere in scene.spheres:
        reach = np.array([[-sphere.radius], [sphere.radius]])
        boxes.append(sphere.center + reach)
    if not boxes:
        right = "it needs a sphere or a triangle with an area"
        refuse(scene.name, "the scene has no geometry", right)
    low = np.min([box.min(axis=0) for box in boxes], axis=0)
    high = np.max([box.max(axis=0) for box in boxes], axis=0)
    extent = float((high - low).max()) / 2
    offset = float(np.abs([low, high]).max())
    if extent < SMALLEST:
        refuse(scene.name, f"the scene is {2 * extent:g} m wide", "give it in metres")
    if offset > REMOTEST * extent:
        wrong = f"the scene is {2 * extent:g} m wide, {offset:g} m from the origin"
        refuse(scene.name, wrong, "move it to the origin: float64 does not resolve it")
    return extent
