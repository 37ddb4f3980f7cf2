"""Paths over a pixel's area, shifted to the same place of another, or with x_1 kept."""

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from restir_gi.extensions.candidates import draw_paths
from restir_gi.extensions.shifting import Criterion, Paths, Shift
from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s, dot
from restir_gi.reference.numerics.records import scatter, take
from restir_gi.reference.numerics.rng import Draw, Uniforms
from restir_gi.reference.options.reprojection import row_at
from restir_gi.reference.resampling.reservoir import Candidates, Reservoirs
from restir_gi.reference.resampling.target import luminance
from restir_gi.reference.scene.camera import Camera, image_points, view_depth
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.caster import STOP
from restir_gi.reference.transport.path_tracer import first_hits
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True)
class PlacedValue:
    """What of N paths depends on the pixel that they belong to.

    Attributes
    ----------
    x, y : (N,) float64, pixels; where x_1 appears in the image
    value : (N, 3) float64, W/(m² sr); contribution f / p
    jacobian : (N,) float64
        Of the shift that brought it here, without that of the place.
    """

    x: Scalars
    y: Scalars
    value: Vec3s
    jacobian: Scalars


@dataclass(frozen=True, slots=True)
class AreaPaths:
    """N paths, and the points of the image through which they are seen.

    Attributes
    ----------
    x, y : (N,) float64, pixels
        Where x_1 appears; x_1 itself is what the camera sees there.
    paths : Paths; all beyond x_1
    """

    x: Scalars
    y: Scalars
    paths: Paths

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.x)

    @property
    def value(self) -> PlacedValue:
        """N rows, as they are here."""
        return PlacedValue(self.x, self.y, self.paths.value, np.ones(len(self)))

    def moved(self, value: PlacedValue, jacobian: Scalars) -> "AreaPaths":
        """The same paths in other pixels.

        Parameters
        ----------
        jacobian : (N,) float64, sr/sr
            Of the whole shift; densities at the joint change by their part of it.
        """
        paths = self.paths.moved(value.value, value.jacobian)
        return AreaPaths(value.x, value.y, paths)


def target(value: PlacedValue) -> Scalars:
    """Luminance of the contribution, (N,) float64; p̂."""
    return luminance(value.value)


def draw_area_paths(
    world: World,
    pixel: Indices,
    place: Draw,
    bounces: int,
    criterion: Criterion,
    number: Indices,
    uniforms: Uniforms,
) -> Candidates:
    """Draw a point of each pixel, and a tree of paths from what is seen there.

    Parameters
    ----------
    pixel : (N,) int; rows of the image
    place : four (N,) float64; lanes 0 and 1: where in the pixel
    number : (N,) int64; of the paths

    Returns
    -------
    Candidates; of `AreaPaths`; the density of a place is 1 in pixels
    """
    width = world.camera.width
    x, y = pixel % width + place[0], pixel // width + place[1]
    points = first_hits(world, x, y)
    tree = draw_paths(
        world,
        points,
        bounces=bounces,
        criterion=criterion,
        number=number,
        uniforms=uniforms,
    )
    return replace(tree, y=AreaPaths(x, y, tree.y))


Primary = Literal["move", "keep"]
"""The primary hit moves with the place in the image, or stays where it is."""


@dataclass(frozen=True, slots=True, eq=False)
class AreaShift:
    """From pixels of one image to pixels of another, or of the same.

    Attributes
    ----------
    shift : Shift; of all beyond x_1
    primary : 'move' or 'keep'; what becomes of x_1
    world_from, world_to : World
        In which the paths were made, and that to which they go.
    """

    shift: Shift
    primary: Primary
    world_from: World
    world_to: World

    @property
    def inverse(self) -> "AreaShift":
        """From the paths' pixels back to where they were made."""
        return AreaShift(self.shift, self.primary, self.world_to, self.world_from)

    def __call__(
        self, samples: AreaPaths, pixel: Indices, dx: Scalars, dy: Scalars
    ) -> tuple[PlacedValue, Scalars]:
        """Shift paths.

        Parameters
        ----------
        pixel : (N,) int; rows of the image to which they go
        dx, dy : (N,) float64, pixels; how far places move, if x_1 moves

        Returns
        -------
        PlacedValue, (N,) float64
            N rows, and the Jacobian of place and path; 0 where the path falls out of
            the pixel, or out of sight.
        """
        size, world_to = len(samples), self.world_to
        if self.primary == "move":
            x, y, factor = samples.x + dx, samples.y + dy, np.ones(size)
            at = np.flatnonzero(row_at(x, y, world_to) == pixel)
            points = first_hits(world_to, x[at], y[at])
        else:
            seen = first_hits(self.world_from, samples.x, samples.y)
            x, y, factor = kept_in_place(self.world_from, world_to, seen)
            inside = (row_at(x, y, world_to) == pixel) & seen.hit
            at = np.flatnonzero(inside)
            points = first_hits(world_to, x[at], y[at])
            same = _same(world_to, take(seen, at), points)
            at, points = at[same], take(points, np.flatnonzero(same))
        everyone = np.arange(len(at))
        value, jacobian = self.shift(world_to, points, everyone, samples.paths, at)
        value, jacobian = scatter(at, value, size), scatter(at, jacobian, size)
        return PlacedValue(x, y, value, jacobian), jacobian * factor


@dataclass(frozen=True, slots=True, eq=False)
class AreaNeighbor:
    """Pixels with an area, whose reservoirs others resample.

    Attributes
    ----------
    shift : AreaShift; from the neighbours to the K receivers
    pixel : (K,) int; rows of the image that the receivers are
    reservoirs : Reservoirs; N rows of `AreaPaths`, a pixel each
    rows : (K,) int; row that each receiver resamples, or ``NONE``
    dx, dy : (K,) float64, pixels
        How far places move from the neighbour to the receiver, if x_1 moves.
    same_domain : bool
        Neighbour and receiver are one pixel of one image: nothing is shifted.
    """

    shift: AreaShift
    pixel: Indices
    reservoirs: Reservoirs
    rows: Indices
    dx: Scalars
    dy: Scalars
    same_domain: bool = False

    def unshifted(self, at: Indices) -> PlacedValue:
        """Value of the neighbours' paths where they are, (A,)."""
        value: PlacedValue = take(self.reservoirs.y.value, self.rows[at])
        return value

    def shifted(self, at: Indices) -> tuple[PlacedValue, Scalars]:
        """The neighbours' paths at the receivers ``at``, which all have one, (A,)."""
        samples = take(self.reservoirs.y, self.rows[at])
        return self.shift(samples, self.pixel[at], self.dx[at], self.dy[at])

    def inverse(self, samples: Any, at: Indices) -> tuple[PlacedValue, Scalars]:
        """The receivers' paths ``at`` back at their neighbours, (A,)."""
        some = take(samples, at)
        return self.shift.inverse(some, self.rows[at], -self.dx[at], -self.dy[at])


def kept_in_place(
    world_from: World, world_to: World, seen: SurfacePoints
) -> tuple[Scalars, Scalars, Scalars]:
    """Where points that one camera sees appear to another.

    Parameters
    ----------
    world_from, world_to : World; of the two cameras; nothing else has moved
    seen : SurfacePoints; N points that the first sees

    Returns
    -------
    x, y : (N,) float64, pixels; in the image of the second; NaN behind it
    jacobian : (N,) float64
        |∂(x, y)_to / ∂(x, y)_from|: both images' pixels per area at the point; 0
        behind the second.
    """
    x_s = contact(world_from.geometry, seen)
    x, y = image_points(world_to.camera, x_s)
    to, here = (
        _pixels_per_area(w.camera, x_s, seen.normal) for w in (world_to, world_from)
    )
    ahead = seen.hit & (here > 0) & np.isfinite(x)
    return x, y, np.divide(to, here, out=np.zeros(len(x)), where=ahead)


def _pixels_per_area(camera: Camera, x_s: Vec3s, normal: Vec3s) -> Scalars:
    """Pixels that a unit of area fills: f² |n · v| / z³, with f pixels a tangent."""
    offset = x_s - np.asarray(camera.position, float)
    z = view_depth(camera, x_s)
    per_tangent = camera.width / 2 / camera.half_width
    across = np.abs(dot(offset, normal)) * per_tangent**2
    density: Scalars = np.divide(across, z**3, out=np.zeros(len(z)), where=z > 0)
    return density


def _same(world: World, a: SurfacePoints, b: SurfacePoints) -> Masks:
    """Whether both are one point: nothing hides it from the second camera."""
    apart = contact(world.geometry, a) - contact(world.geometry, b)
    near = dot(apart, apart) < (STOP * world.geometry.extent) ** 2
    same: Masks = (a.primitive == b.primitive) & near
    return same
