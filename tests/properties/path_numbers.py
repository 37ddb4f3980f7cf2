"""Random numbers of base paths, and those that draw the shifted ones elsewhere.

Hits are met again on their planes in float64.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from restir_gi.extensions.shifting import Technique
from restir_gi.reference.numerics.arrays import dot
from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.materials.parameters import Kind
from restir_gi.reference.scene.origins import contact
from tests.properties.path_inverses import directions, guessed, inverted
from tests.properties.path_scenes import (
    SIZE,
    drawn,
    left_from,
    neighbors,
    seen_from,
    shifted,
    steepness,
)

SOLVED = 1e-13
"""What Newton's method may miss a direction by: over steps of 1e-4 it is 1e-9."""

NEAR = 0.1
"""Metres between the points that are joined, at most, in the near scene."""

BOUNCES = 4
DIMENSIONS = 2 * (BOUNCES + 1)
PLAIN = (Kind.LAMBERTIAN, Kind.ROUGH_CONDUCTOR)
"""Materials of one lobe: a direction has one pair of numbers."""


@dataclass(frozen=True)
class Joints:
    """Where N paths are joined: x_(c-1) of both pixels, and the paths."""

    world: object
    x_from: object
    x_to: object
    paths: object

    def of(self, rows):
        """Some of the rows."""
        three = (take(part, rows) for part in (self.x_from, self.x_to, self.paths))
        return Joints(self.world, *three)

    @property
    def chosen(self):
        """(N,) bool: light follows that is chosen, and no direction is drawn at x_c."""
        paths = self.paths
        by_light_sampling = paths.technique == Technique.NEXT_EVENT
        return (paths.end == paths.joint) & by_light_sampling

    def point(self, u):
        """x_c, where the ray of the first two numbers meets its plane."""
        triangle = self.world.geometry.triangle[self.paths.surface.primitive]
        corner, normal = triangle[:, 0], triangle[:, 3]
        x, omega = self.x_from.position, directions(self.world, self.x_from, u[:, :2])
        distance = dot(corner - x, normal) / dot(omega, normal)
        return x + distance[:, None] * omega

    def targets(self, u):
        """Directions from x_(c-1) and x_c on the offset path; x_c as it sees it."""
        w, x_s = self.world, self.point(u)
        there, _ = seen_from(w, self.x_to, self.paths.surface, x_s)
        return -there.wo, self.onward(u, x_s), there

    def onward(self, u, x_s):
        """Directions from x_c, where one is drawn."""
        near, _ = seen_from(self.world, self.x_from, self.paths.surface, x_s)
        used = np.where(self.chosen[:, None], 0.5, u[:, 2:])
        return directions(self.world, near, used)

    def first_guess(self, u):
        """Of the offset path's numbers."""
        omega, onward, there = self.targets(u)
        guess = [guessed(self.world, self.x_to, omega)]
        guess.append(guessed(self.world, there, onward))
        return np.concatenate(guess, axis=1)

    def mapped(self, u, guess):
        """The offset path's four numbers, and by how much they miss it."""
        omega, onward, there = self.targets(u)
        first, error = inverted(self.world, self.x_to, omega, guess[:, :2])
        second, rows = u[:, 2:].copy(), np.flatnonzero(~self.chosen)
        some, start = take(there, rows), guess[rows, 2:]
        second[rows], further = inverted(self.world, some, onward[rows], start)
        error[rows] += further
        return np.concatenate([first, second], axis=1), error

    def rounding(self, u):
        """Relative change of the Jacobian from the exact x_c to the one on record.

        That is a float32 hit, δ away, seen from both pixels: see `steepness`.  The
        direction on record leads to another such hit, and is off by an angle.
        """
        w, paths, exact = self.world, self.paths, self.point(u)
        x_s = contact(w.geometry, paths.surface)
        moved = np.linalg.norm(exact - x_s, axis=1)
        angle = np.linalg.norm(paths.wi - self.onward(u, exact), axis=1)
        angle = np.where(self.chosen, 0.0, angle)
        change = np.zeros(len(paths))
        for x in (self.x_from, self.x_to):
            there, d = seen_from(w, x, paths.surface, x_s)
            steep = steepness(w, x, -there.wo, x.wo)
            steep = steep + steepness(w, there, there.wo, paths.wi)
            change = change + moved / d * (2.0 + steep)
            change = change + angle * steepness(w, there, paths.wi, there.wo)
        return change


@dataclass(frozen=True)
class ShiftedPaths:
    """Paths of a frame that were shifted and have one joint."""

    joints: Joints
    jacobian: np.ndarray
    there: object
    x_to: object
    shift: object

    @property
    def table(self):
        """(D, 4, N) random numbers of the base paths."""
        uniforms = self.shift.uniforms(self.there.number)
        return np.array([uniforms.draw(d) for d in range(DIMENSIONS)])

    def places(self):
        """Where in the table the four numbers stand that choose the directions."""
        before = 2 * (self.there.joint.astype(int) - 2)
        rows = np.arange(len(self.there))
        return [(before + step, lane, rows) for step in (0, 2) for lane in (1, 2)]


def joined(name, kind, frame, kinds=PLAIN):
    """Those whose joint lies between materials of these kinds."""
    w, x, found, shift = drawn(name, kind, frame, BOUNCES)
    x_to = take(x, neighbors(SIZE, 2, -1))
    lit = found.y.value.any(axis=1) & (found.y.joint > 0)
    there, jacobian = shifted(shift, w, x_to, found.y, lit)
    at = np.flatnonzero(jacobian > 0)
    paths, ends = take(found.y, at), [take(points, at) for points in (x, x_to)]
    x_from, y = (left_from(w, points, paths, shift) for points in ends)
    single = np.ones(len(at), bool)
    for points in (x_from, y, paths.surface):
        single &= np.isin(w.materials.kind[points.material], kinds)
    if name == "near":
        x_s = contact(w.geometry, paths.surface)
        single &= seen_from(w, x_from, paths.surface, x_s)[1] < NEAR
    rows = np.flatnonzero(single)
    joints = Joints(w, x_from, y, paths).of(rows)
    at = at[rows]
    return ShiftedPaths(joints, jacobian[at], take(there, at), take(x_to, at), shift)


@cache
def solved(name, kind, frame):
    """Shifted paths, their numbers, those that draw them there, and the misses."""
    found = joined(name, kind, frame)
    table = found.table
    u = np.stack([table[place] for place in found.places()], axis=1)
    v, error = found.joints.mapped(u, found.joints.first_guess(u))
    return found, u, v, error
