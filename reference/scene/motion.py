"""Where points were a frame ago: rigid motion between two frames of an animation."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    dot,
    vectors,
)
from restir_gi.reference.scene.animation import check_rigid
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere
from restir_gi.reference.system.errors import UsageError


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Rigid motion of each shape of a scene from one frame to another.

    Attributes
    ----------
    rotation : (S, 3, 3) float64
        Of each shape, in the order of
        :attr:`restir_gi.reference.scene.geometry.Geometry.shape`.
    translation : (S, 3) float64, m; x after = rotation · x before + translation
    """

    rotation: Scalars
    translation: Vec3s

    @property
    def reversed(self) -> "Motion":
        """The way back."""
        back = np.swapaxes(self.rotation, 1, 2)
        return Motion(back, -np.einsum("sij,sj->si", back, self.translation))

    @property
    def moves(self) -> Masks:
        """(S,) bool: the shape does not stay where it was."""
        turned = (self.rotation != np.eye(3)).any(axis=(1, 2))
        moved: Masks = turned | (self.translation != 0).any(axis=1)
        return moved


def motion_between(before: Scene, after: Scene) -> Motion | None:
    """Motion of the shapes from one frame to the next.

    Parameters
    ----------
    before, after : Scene; two frames of one animation

    Returns
    -------
    Motion or None; ``None`` where every shape stays: nothing needs to be carried

    Raises
    ------
    UsageError
        The frames have not the same shapes, or one of them did not move rigidly.
    """
    if _names(before) != _names(after):
        raise UsageError(
            f"{after.name}: every frame must have the same shapes in the same order"
        )
    meshes = zip(before.meshes, after.meshes, strict=True)
    spheres = zip(before.spheres, after.spheres, strict=True)
    moves = [_mesh_move(after.name, a, b) for a, b in meshes]
    moves += [_sphere_move(after.name, a, b) for a, b in spheres]
    matrices = np.array(moves).reshape(-1, 4, 4)
    motion = Motion(matrices[:, :3, :3], matrices[:, :3, 3])
    return motion if motion.moves.any() else None


def _names(scene: Scene) -> tuple[list[str], list[str]]:
    return [m.name for m in scene.meshes], [s.name for s in scene.spheres]


def _sphere_move(where: str, before: Sphere, after: Sphere) -> Scalars:
    if before.radius != after.radius:
        raise UsageError(f'{where}: sphere "{after.name}" changes its radius')
    move = np.eye(4)
    move[:3, 3] = np.subtract(after.center, before.center)
    return move


def _mesh_move(where: str, before: Mesh, after: Mesh) -> Scalars:
    if before.vertices is not after.vertices or before.faces is not after.faces:
        raise UsageError(f'{where}: mesh "{after.name}" changes its own shape')
    if before.pose is after.pose or (before.pose == after.pose).all():
        return np.eye(4)
    move: Scalars = after.pose @ np.linalg.inv(before.pose)
    # The inverse leaves rounding in what is 0, 0, 0, 1.
    move[3] = (0, 0, 0, 1)
    check_rigid(f'{where}: motion of mesh "{after.name}"', move)
    return move


def carry(motion: Motion | None, shape: Indices, x: Vec3s) -> Vec3s:
    """Points that move with their shapes.

    Parameters
    ----------
    shape : (N,) int; shape that each point belongs to
    x : (N, 3) float64, m; before

    Returns
    -------
    (N, 3) float64, m; after; bit for bit the same on shapes that stay
    """
    if motion is None:
        return x
    moves = motion.moves[shape]
    moved = turn(motion, shape, x) + motion.translation[shape]
    return np.where(moves[:, None], moved, x)


def turn(motion: Motion | None, shape: Indices, n: Vec3s) -> Vec3s:
    """Directions that turn with their shapes, (N, 3) float64; after.

    Parameters
    ----------
    shape : (N,) int; shape that each direction belongs to
    n : (N, 3) float64; before
    """
    if motion is None:
        return n
    rotation = motion.rotation[shape]
    return vectors(*(dot(rotation[:, i], n) for i in range(3)))
