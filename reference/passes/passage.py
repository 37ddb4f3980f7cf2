"""The way from one frame of an animation to the next, and back, for samples."""

from dataclasses import dataclass, replace

from reference.arrays import Indices, Masks, Vec3s
from reference.passes.replay import Replay
from reference.resampling.reservoir import Samples
from reference.scene.motion import Motion, carry, motion_between, turn
from reference.scene.surface import SurfacePoints
from reference.world import World, same_but_for_the_camera


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """What becomes of samples between the last frame and this one.

    A sample goes with the shape it lies on, whose motion keeps areas and angles, and
    its radiance is found again with the same random numbers.  So the only Jacobian on
    the way is that of the reconnection.

    Attributes
    ----------
    before, after : World
        Of the last frame and of this one.
    forth, back : Motion or None
        Of the shapes; ``None`` where all of them stay.
    replay : Replay or None
        Finds radiance again; ``None`` where only the camera has moved.
    """

    before: World
    after: World
    forth: Motion | None
    back: Motion | None
    replay: Replay | None

    def arrive(self, y: Samples, active: Masks) -> Samples:
        """Samples of the last frame, as they are in this one.

        Parameters
        ----------
        y : Samples
            N rows, with their suffix unless only the camera has moved.
        active : (N,) bool
            Which are of interest; the radiance of the others is 0.

        Returns
        -------
        Samples
            N rows.
        """
        return _passed(self.after, self.forth, self.replay, y, active)

    def depart(self, y: Samples, active: Masks) -> Samples:
        """Samples of this frame, as they were in the last one.

        Parameters
        ----------
        y : Samples
            N rows, with their suffix unless only the camera has moved.
        active : (N,) bool
            Which are of interest; the radiance of the others is 0.

        Returns
        -------
        Samples
            N rows.
        """
        return _passed(self.before, self.back, self.replay, y, active)

    def beside(self, y: Samples, x: Vec3s) -> Vec3s:
        """Where points of the last frame stand, seen from samples that have moved on.

        Parameters
        ----------
        y : Samples
            N samples.
        x : (N, 3) float64, m
            Points beside them in the last frame.

        Returns
        -------
        (N, 3) float64, m
            At the same distance and angle from the samples in this frame.
        """
        return x if self.forth is None else carry(self.forth, _shape(self.after, y), x)

    def beside_before(self, y: Samples, x: Vec3s) -> Vec3s:
        """Where points of this frame stand, seen from samples that are led back.

        Parameters
        ----------
        y : Samples
            N samples.
        x : (N, 3) float64, m
            Points beside them in this frame.

        Returns
        -------
        (N, 3) float64, m
            At the same distance and angle from the samples in the last frame.
        """
        return x if self.back is None else carry(self.back, _shape(self.after, y), x)


def passage_between(before: World, after: World, replay: Replay) -> Passage | None:
    """Way from one frame to the next.

    Parameters
    ----------
    before, after : World
        Two frames of one animation.
    replay : Replay
        How radiance is found again.

    Returns
    -------
    Passage or None
        ``None`` where the worlds are the same, camera and all: a scene that does not
        move pays nothing for motion.
    """
    if before is after and not after.plan.motion:
        return None
    if same_but_for_the_camera(before.scene, after.scene):
        return Passage(before, after, None, None, None)
    forth = motion_between(before.scene, after.scene)
    back = forth.reversed if forth else None
    return Passage(before, after, forth, back, replay)


def _shape(world: World, y: Samples) -> Indices:
    assert y.suffix is not None
    shapes: Indices = world.geometry.shape[y.suffix.surface.primitive]
    return shapes


def _passed(
    world: World,
    motion: Motion | None,
    replay: Replay | None,
    y: Samples,
    active: Masks,
) -> Samples:
    if replay is None:
        return y
    assert y.suffix is not None
    position, normal, suffix = y.position, y.normal, y.suffix
    if motion:
        shape = _shape(world, y)
        position, normal = carry(motion, shape, position), turn(motion, shape, normal)
        suffix = replace(suffix, surface=_moved(motion, shape, suffix.surface))
    return Samples(position, normal, replay.radiance(world, suffix, active), suffix)


def _moved(motion: Motion, shape: Indices, points: SurfacePoints) -> SurfacePoints:
    smooth = points.smooth
    return replace(
        points,
        position=carry(motion, shape, points.position),
        normal=turn(motion, shape, points.normal),
        smooth=None if smooth is None else turn(motion, shape, smooth),
        wo=turn(motion, shape, points.wo),
    )
