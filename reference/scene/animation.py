"""Scenes that change: a function from the number of a frame to the scene of it.

Every frame has the same shapes in the same order, so that a triangle or sphere keeps
its number; what moves are their poses, the camera and the lights.  A part that stays is
the same object in the next frame, which is how a frame knows that it has nothing to do.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere
from restir_gi.reference.system.errors import UsageError

RIGID = 1e-9
"""How far a pose's rotation may be from orthonormal: rounding, and no scale."""

Changes = Literal["nothing", "camera", "scene"]


@dataclass(frozen=True, slots=True)
class Animation:
    """The scene of each frame.

    Attributes
    ----------
    scene_at : callable; scene of a frame, numbered from 0
    changes : 'nothing', 'camera' or 'scene'
        What may differ between two frames: known beforehand, since samples must keep
        more of their history in a scene whose light may change.
    """

    scene_at: Callable[[int], Scene]
    changes: Changes

    def __call__(self, frame: int) -> Scene:
        """Scene of a frame."""
        return self.scene_at(frame)


def still(scene: Scene) -> Animation:
    """Animate nothing.

    Parameters
    ----------
    scene : Scene; validated
    """
    return Animation(lambda frame: scene, "nothing")


def with_camera(animation: Animation, camera_at: Callable[[int], Camera]) -> Animation:
    """Move the camera."""
    changes: Changes = "scene" if animation.changes == "scene" else "camera"
    return Animation(
        lambda frame: replace(animation(frame), camera=camera_at(frame)), changes
    )


def with_shape(
    animation: Animation, name: str, move_at: Callable[[int], Scalars]
) -> Animation:
    """Move a mesh or a sphere, with the shape moved.

    Parameters
    ----------
    name : str; of the shape, or of several that move together
    move_at : callable
        Rigid (4, 4) motion of each frame, in the world, away from where the shape
        stands in ``animation``.

    Raises
    ------
    UsageError
        When a frame is asked for: no such shape, or the motion is not rigid.
    """

    def at(frame: int) -> Scene:
        scene, move = animation(frame), np.asarray(move_at(frame), float)
        check_rigid(f'{scene.name}: motion of "{name}" in frame {frame}', move)
        names = [m.name for m in scene.meshes] + [s.name for s in scene.spheres]
        if name not in names:
            raise UsageError(f'{scene.name}: no shape is called "{name}"')
        return replace(
            scene,
            meshes=tuple(
                _moved_mesh(m, move) if m.name == name else m for m in scene.meshes
            ),
            spheres=tuple(
                _moved_sphere(s, move) if s.name == name else s for s in scene.spheres
            ),
        )

    return Animation(at, "scene")


def with_change(
    animation: Animation, frame: int, change: Callable[[Scene], Scene]
) -> Animation:
    """Change the scene at once, from frame ``frame`` on: switch a light, say.

    Parameters
    ----------
    animation : Animation; the scenes before
    change : callable; scene to scene; shapes keep their number and order
    """
    return Animation(
        lambda t: change(animation(t)) if t >= frame else animation(t), "scene"
    )


def check_rigid(where: str, move: Scalars) -> None:
    """Refuse what is not a rotation and a translation.

    Parameters
    ----------
    move : (4, 4) float64; world to world

    Raises
    ------
    UsageError
        One line.
    """
    rotation = move[:3, :3]
    orthonormal = np.abs(rotation @ rotation.T - np.eye(3)).max() <= RIGID
    last = (move[3] == (0, 0, 0, 1)).all()
    if not (orthonormal and last and np.linalg.det(rotation) > 0):
        raise UsageError(f"{where} is not rigid; give a rotation and a translation")


def _moved_mesh(mesh: Mesh, move: Scalars) -> Mesh:
    return replace(mesh, pose=move @ mesh.pose)


def _moved_sphere(sphere: Sphere, move: Scalars) -> Sphere:
    x, y, z = (float(v) for v in move[:3, :3] @ sphere.center + move[:3, 3])
    return replace(sphere, center=(x, y, z))
