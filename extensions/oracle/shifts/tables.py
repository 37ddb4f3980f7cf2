"""Tables of offset walks: all that a shift needs of rays and materials."""

from dataclasses import replace
from typing import Any

import numpy as np

from restir_gi.extensions.oracle.shifts.scenes import DrawnPaths
from restir_gi.extensions.oracle.shifts.walks import ReplayedWalk
from restir_gi.extensions.shifting import (
    NEVER_JOINED,
    Criterion,
    Paths,
    Technique,
    segment,
)
from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s, dot
from restir_gi.reference.numerics.records import scatter, take
from restir_gi.reference.numerics.rng import Uniforms
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.scene.materials.parameters import Kind, MaterialTable
from restir_gi.reference.scene.materials.table import pdf, scattering
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.direct_light import (
    bsdf_sampling_weight,
    choose_light,
    emitter_hits,
)
from restir_gi.reference.transport.world import World


def columns(world: World, walk: ReplayedWalk) -> dict[str, Any]:
    """A walk as buffers, (N, V) or (N, V, 3) each."""
    points = [step.points for step in walk.steps]
    lobes = [lobes_of(world.materials, x) for x in points]
    found = {
        "hit": [x.hit for x in points],
        "position": [x.position for x in points],
        "contact": [contact(world.geometry, x) for x in points],
        "alpha": [alpha for alpha, _ in lobes],
        "single": [single for _, single in lobes],
        "weight": list(walk.weights),
        "delta": [leaving.bsdf.delta for leaving in walk.leavings],
    }
    tables = {name: np.stack(rows, axis=1) for name, rows in found.items()}
    flags = {n: t.astype(np.uint32) for n, t in tables.items() if t.dtype == bool}
    return tables | flags


def lobes_of(table: MaterialTable, points: SurfacePoints) -> tuple[Scalars, Masks]:
    """Widths of microfacets, and who is never joined.

    Returns
    -------
    (N,) float64, (N,) bool
        1 for diffuse surfaces and for what lies under a smooth coat; 0 for misses.
    """
    kind = table.kind[points.material]
    rough = (kind == Kind.ROUGH_CONDUCTOR) | (kind == Kind.ROUGH_COATED)
    single = np.isin(kind, NEVER_JOINED)
    alpha = np.where(rough, table.alpha[points.material], np.where(single, 0.0, 1.0))
    return np.where(points.hit, alpha, 0.0), single & points.hit


def connection(
    frame: DrawnPaths, criterion: Criterion, x: SurfacePoints, paths: Paths
) -> dict[str, Any]:
    """What joins points to the joints of paths.

    Parameters
    ----------
    x : SurfacePoints; x_(c-1), N points

    Returns
    -------
    dict of str to array
        Buffers of the connection.  Where x_(c-1) is behind x_c, light is reflected as
        if it came from the mirrored side: only the horizon itself refuses it.
    """
    world, table = frame.world, frame.world.materials
    there, _ = segment(criterion, world.geometry, x, paths.surface)
    omega = -there.wo
    height = dot(there.normal, there.wo)
    below = height < 0
    mirrored = there.wo - 2.0 * np.minimum(height, 0.0)[:, None] * there.normal
    seen = replace(there, wo=mirrored)
    x_s = contact(world.geometry, there)
    joins = x.hit & (paths.joint > 0)
    free = world.caster.visible(x, x_s, there.normal, joins & ~below, "reuse")
    return {
        "left": scattering(table, x, omega),
        "pdf_left": pdf(table, x, omega),
        "onward": scattering(table, seen, paths.wi),
        "pdf_onward": pdf(table, seen, paths.wi),
        "seen": (free | below).astype(np.uint32),
    }


def joints(frame: DrawnPaths, paths: Paths) -> dict[str, Any]:
    """Reconnection vertices as buffers, of what has no joint: any."""
    alpha, single = lobes_of(frame.world.materials, paths.surface)
    return {
        "joint_position": contact(frame.world.geometry, paths.surface),
        "joint_normal": paths.surface.normal,
        "joint_alpha": alpha,
        "joint_single": single.astype(np.uint32),
    }


def lights(world: World, walk: ReplayedWalk, paths: Paths, uniforms: Uniforms) -> Vec3s:
    """Light that reaches x_end by the technique of the base path.

    Returns
    -------
    (N, 3) float64; reflected towards x_(end-1), with its share; 0 without a point x_end
    """
    found = np.zeros((len(paths), 3))
    chosen = paths.technique == Technique.NEXT_EVENT
    for v in range(2, len(walk.steps) + 1):
        x, leaving = walk.steps[v - 1].points, walk.leavings[v - 1]
        here = (paths.end == v) & x.hit
        light = choose_light(world, x, uniforms.draw(2 * v - 1), here & chosen)
        rows, radiance, p_light = emitter_hits(world, x, leaving.bsdf, leaving.hits)
        bsdf = take(leaving.bsdf, rows)
        share = bsdf_sampling_weight(bsdf.pdf, bsdf.delta, p_light)
        met = leaving.bsdf.weight * scatter(rows, radiance * share[:, None], len(paths))
        found = np.where((here & chosen)[:, None], light.value, found)
        found = np.where((here & ~chosen)[:, None], met, found)
    return found


def filled(there: Masks, offset: Buffers, base: Buffers) -> dict[str, Any]:
    """Numbers of the offset walk, and the base path's where it has none.

    Parameters
    ----------
    there : (N,) or (N, V) bool; whether it has

    Returns
    -------
    dict of str to array; a mistake that does not ask finds something to go on with
    """
    found = {}
    for name, array in offset.items():
        mask = there.reshape(there.shape + (1,) * (array.ndim - there.ndim))
        found[name] = np.where(mask, array, base[name])
    return found
