"""How reservoirs are kept between passes: as they are, rounded, or in 48 bytes."""

from dataclasses import replace
from typing import Any

import numpy as np

from restir_gi.reference.numerics.records import map_rows, nbytes
from restir_gi.reference.resampling.packing.paper import pack, unpack
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.settings import Storage

SHORT: dict[Storage, type[np.floating[Any]]] = {
    "float32": np.float32,
    "half": np.float16,
}
PAPER_BYTES = 48


def stored(
    storage: Storage, points: SurfacePoints, r: Reservoirs, pixels: int
) -> Reservoirs:
    """Reservoirs as they come back from memory.

    Parameters
    ----------
    storage : 'float64', 'float32', 'half' or 'paper'
        Untouched, through a shorter type, or through 48 bytes each.

    Notes
    -----
    [Ouyang21, section 5]; errors as
    :func:`restir_gi.reference.resampling.packing.paper.pack` states them.  The 32 bits
    of the seed hold the number of the path, modulo the largest multiple of ``pixels``
    that they can: at 1920 x 1080 pixels it repeats after 2071 frames.  The rest of the
    path, which a moving scene wants too, is not counted among the 48 bytes and keeps
    its precision.
    """
    if storage == "float64":
        return r
    if storage in SHORT:
        return _rounded(r, SHORT[storage])
    seed = np.zeros(len(r.W), np.uint32)
    if r.y.suffix:
        seed = (r.y.suffix.number % (2**32 // pixels * pixels)).astype(np.uint32)
    codes = pack(points.position, points.normal, r, seed)
    _, _, back, _ = unpack(codes)
    return replace(back, y=replace(back.y, suffix=r.y.suffix))


def stored_bytes(storage: Storage, r: Reservoirs) -> int:
    """Memory that reservoirs take between passes.

    Bytes; the rest of the paths, where it is kept, is never shortened.
    """
    suffix = nbytes(r.y.suffix)
    if storage == "paper":
        return PAPER_BYTES * len(r.W) + suffix
    bare = replace(r, y=replace(r.y, suffix=None))
    if storage in SHORT:
        dtype = SHORT[storage]
        bare = map_rows(lambda a: a.astype(dtype) if a.dtype.kind == "f" else a, bare)
    return nbytes(bare) + suffix


def _rounded(r: Reservoirs, dtype: type[np.floating[Any]]) -> Reservoirs:
    """Each number rounded to a type; beyond its largest that one, never infinite.

    The rest of the path keeps its precision, as in the paper's 48 bytes.
    """
    most = float(np.finfo(dtype).max)

    def through(a: Any) -> Any:
        if a.dtype.kind != "f":
            return a
        return np.clip(a, -most, most).astype(dtype).astype(a.dtype)

    bare = map_rows(through, replace(r, y=replace(r.y, suffix=None)))
    return replace(bare, y=replace(bare.y, suffix=r.y.suffix))
