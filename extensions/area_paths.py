"""Paths of which the place in the image is a part: samples of a pixel's whole area."""

from dataclasses import dataclass, replace

import numpy as np

from restir_gi.extensions.candidates import draw_paths
from restir_gi.extensions.shifting import Criterion, Paths
from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.numerics.rng import Draw, Uniforms
from restir_gi.reference.resampling.reservoir import Candidates
from restir_gi.reference.resampling.target import luminance
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
