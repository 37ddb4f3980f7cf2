"""Samples of a frame in another one: the temporal shift, and neighbours a frame ago."""

from dataclasses import dataclass, replace

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.options.replay import Replay
from restir_gi.reference.passes.pixels import FrameReservoirs, NeighborPixels, Pixels
from restir_gi.reference.resampling.reservoir import Samples
from restir_gi.reference.scene.motion import Motion, carry, motion_between, turn
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World, same_but_for_the_camera


@dataclass(frozen=True, slots=True, eq=False)
class TemporalShift:
    """What becomes of samples between the last frame and this one.

    A sample goes with the shape it lies on, whose motion keeps areas and angles, and
    its radiance is found again with the same random numbers.  So the only Jacobian on
    the way is that of the reconnection.

    Attributes
    ----------
    before, after : World; of the last frame and of this one
    motion, reverse : Motion or None
        Of the shapes, and back; ``None`` where all of them stay.
    replay : Replay or None
        Finds radiance again; ``None`` where only the camera has moved.
    """

    before: World
    after: World
    motion: Motion | None
    reverse: Motion | None
    replay: Replay | None

    def forward(self, y: Samples, active: Masks) -> Samples:
        """Samples of the last frame as they are in this one.

        Parameters
        ----------
        y : Samples; N rows, with their suffix unless only the camera has moved
        active : (N,) bool; which are of interest; the radiance of the others is 0
        """
        return _carried(self.after, self.motion, self.replay, y, active)

    def backward(self, y: Samples, active: Masks) -> Samples:
        """Samples of this frame as they were in the last one, (N,); as `forward`."""
        return _carried(self.before, self.reverse, self.replay, y, active)

    def points_forward(self, y: Samples, x: Vec3s) -> Vec3s:
        """Points x of the last frame, carried along with the shapes of samples y.

        (N, 3), m: at the same distance and angle from the samples as then.
        """
        return x if self.motion is None else carry(self.motion, self._shape(y), x)

    def points_backward(self, y: Samples, x: Vec3s) -> Vec3s:
        """Points x of this frame, led back with the shapes of samples y; (N, 3), m."""
        return x if self.reverse is None else carry(self.reverse, self._shape(y), x)

    def _shape(self, y: Samples) -> Indices:
        return _shape(self.after, y)


def temporal_shift(before: World, after: World, replay: Replay) -> TemporalShift | None:
    """Shift from one frame of an animation to the next.

    ``None`` where the worlds are the same, camera and all: a scene that does not move
    pays nothing for motion.
    """
    if before is after and not after.plan.motion:
        return None
    if same_but_for_the_camera(before.scene, after.scene):
        return TemporalShift(before, after, None, None, None)
    motion = motion_between(before.scene, after.scene)
    reverse = motion.reversed if motion else None
    return TemporalShift(before, after, motion, reverse, replay)


@dataclass(frozen=True, slots=True, eq=False)
class EarlierReservoirs(FrameReservoirs):
    """Reservoirs of the last frame, where something has moved since.

    Attributes
    ----------
    shift : TemporalShift; from the last frame to this one
    """

    shift: TemporalShift

    def neighbors(self, q: Pixels, rows: Indices) -> "EarlierPixels":
        """Pixels ``rows``, (K,), of the last frame; their samples brought to this."""
        n = FrameReservoirs.neighbors(self, q, rows)
        r = n.reservoirs
        y = self.shift.forward(r.y, (rows != NONE) & (r.W > 0))
        return EarlierPixels(q, self, rows, n.x, replace(r, y=y), self.shift)


@dataclass(frozen=True, slots=True, eq=False)
class EarlierPixels(NeighborPixels):
    """Pixels q_n of the last frame, where something has moved since.

    Attributes
    ----------
    temporal_shift : TemporalShift; from the last frame to this one
    """

    temporal_shift: TemporalShift

    def jacobian(self) -> Scalars:
        """|∂ω_q / ∂ω_n|, with x_n carried along beside its sample; (K,), sr/sr."""
        y = self.reservoirs.y
        x_n = self.temporal_shift.points_forward(y, self.x.position)
        return self.q.shift(x_n, self.q.points.position, y)

    def before(self, y: Samples, asked: Masks) -> tuple[Samples, Vec3s]:
        """Samples at q as they were in the last frame, (K,), and x_v of q with them."""
        x_q = self.temporal_shift.points_backward(y, self.q.points.position)
        return self.temporal_shift.backward(y, asked), x_q

    def supports(self, y: Samples) -> Masks:
        """As then, (K,): a sample that shines now may have been dark."""
        shone: Masks = y.radiance.any(axis=1) & NeighborPixels.supports(self, y)
        return shone


def _shape(world: World, y: Samples) -> Indices:
    assert y.suffix is not None
    shapes: Indices = world.geometry.shape[y.suffix.surface.primitive]
    return shapes


def _carried(
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
