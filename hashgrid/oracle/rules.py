"""What passes of the hash grid are replayed with: the contract, or a known mistake."""

from dataclasses import dataclass, field
from math import pi

from restir_gi.extensions.oracle.reuse.rules import ReuseRules
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.replay.rules import Rules

SLOTS = 16
"""Of a bucket."""


@dataclass(frozen=True, slots=True)
class CellRules:
    """The cell of a point.

    Attributes
    ----------
    fov_scale : float; factor of the field of view
    quotients : 'larger', 'smaller' or 'turned'
        Which of 1 / height and height / width² counts; or of those with width and
        height exchanged the larger.
    widest : float; angle, in radians, under which a cell is seen at most
    levels : 'contract' or 'own'; the rule of the backend itself gives the level
    eye_of_now : bool; a look-up has the eye and the base of this frame
    eye_forgotten : bool; distances are those from the origin
    rounding : 'down', 'up' or 'nearest'; how log2 becomes a level
    smallest : float, m; edge of the cells of level 0, in the level and in the edge
    least_level : bool; no level is below 0
    reach : float; in edges, how far a point is moved along a tangent
    one_sided : bool; u stands in place of 2 u − 1
    plane : 'tangent' or 'ground'; in which the point is moved, that of x and z
    one_number : bool; both tangents have the first one
    cut : 'floor', 'trunc' or 'round'; how positions become whole
    edge_doubles : bool; the edge is 0.001 · 2^level, not 0.001 · level
    parts : bool; the normal is looked at
    parts_turned : bool; its z counts in units
    """

    fov_scale: float = 1.0
    quotients: str = "larger"
    widest: float = pi / 4
    levels: str = "contract"
    eye_of_now: bool = False
    eye_forgotten: bool = False
    rounding: str = "down"
    smallest: float = 1e-3
    least_level: bool = True
    reach: float = 2.0**0.5
    one_sided: bool = False
    plane: str = "tangent"
    one_number: bool = False
    cut: str = "floor"
    edge_doubles: bool = True
    parts: bool = True
    parts_turned: bool = False


@dataclass(frozen=True, slots=True)
class HashRules:
    """Hash and checksum of a cell.

    Attributes
    ----------
    own : bool; any words that tell cells apart
    order : tuple of str; of the fields, the innermost first
    nested : bool; else each is added to what the hash of the others gives
    saturates : bool; a negative coordinate becomes 0
    one_hash : bool; the checksum is the hash of the bucket
    exchanged : bool; the bucket has xxHash, the checksum PCG
    lifted : 'least' or 'never'; a checksum of 0 becomes 1
    """

    own: bool = False
    order: tuple[str, ...] = ("facing", "z", "y", "x", "level")
    nested: bool = True
    saturates: bool = False
    one_hash: bool = False
    exchanged: bool = False
    lifted: str = "least"


@dataclass(frozen=True, slots=True)
class TableRules:
    """Slots of cells, and the lists of their vertices.

    Attributes
    ----------
    bucket_of : 'remainder' or 'upper bits'; which bucket is that of a hash
    told_apart : 'by checksum', 'never' or 'each vertex'; who shares a slot
    probes : int; slots of a bucket that are tried
    overflow : 'lost', 'last slot' or 'next bucket'; where a cell goes whose is full
    winners_alone : bool; of a cell one vertex has the slot, and the others are lost
    inactive_too : bool; all vertices are inserted
    cleared : bool; counters begin at 0
    first_place : int; what the counter gives who comes first
    restarts : int; rows after which the prefix sum is 0 again; 0: never
    inclusive : bool; the counter of the cell itself is in its base
    numbers : 'rows', 'appended' or 'slots'; what is stored of a vertex
    looked_at : int; slots of a bucket, by a look-up
    looks_further : bool; a look-up goes on in the next bucket
    checksum_compared : bool; by a look-up
    gives_free_slot : bool; a look-up that fails ends in the first slot that is free
    walk : 'any', 'from the first', 'twice', 'beyond' or 'next cell'
        Vertices that are visited: of any walk that is even; from the first on; those of
        a small cell again and again; without coming round; or of the cell after it.
    """

    bucket_of: str = "remainder"
    told_apart: str = "by checksum"
    probes: int = SLOTS
    overflow: str = "lost"
    winners_alone: bool = False
    inactive_too: bool = False
    cleared: bool = True
    first_place: int = 0
    restarts: int = 0
    inclusive: bool = False
    numbers: str = "rows"
    looked_at: int = SLOTS
    looks_further: bool = False
    checksum_compared: bool = True
    gives_free_slot: bool = False
    walk: str = "any"


@dataclass(frozen=True, slots=True)
class LightRules:
    """Light of cells.

    Attributes
    ----------
    similar : 'fourth power', 'cosine', 'square', 'both sides' or 'inverted'
        What is held against 1/2.
    surface_cosine, light_cosine : 'above 0', 'absolute' or 'left out'
        How the target has each, and whether it is 0 behind.
    distances : int; power of the distance that is divided by
    pi, albedo, area : bool; whether it is in the target
    choice, density : bool; whether a candidate's weight is divided by it
    times_pdf : bool; it is multiplied by both instead
    nulls_count : bool; candidates without light
    counted : 'K', '1' or 'nothing'; what the sum of weights is divided by
    confidence : 'K' or '1'; M that is kept
    first_target : bool; W is divided by the target of the first candidate
    kept_by : 'sum', 'sum before' or 'turned'; how u decides
    held : str; as what W and M of candidates are stored, by its name in `HALVES`
    reuse : ReuseRules; of the reservoirs of a cell
    """

    similar: str = "fourth power"
    surface_cosine: str = "above 0"
    light_cosine: str = "above 0"
    distances: int = 2
    pi: bool = True
    albedo: bool = True
    area: bool = True
    choice: bool = True
    density: bool = True
    times_pdf: bool = False
    nulls_count: bool = True
    counted: str = "K"
    confidence: str = "K"
    first_target: bool = False
    kept_by: str = "sum"
    held: str = "exact"
    reuse: ReuseRules = field(default=ReuseRules())


@dataclass(frozen=True, slots=True)
class SuffixRules:
    """Suffixes of paths in cells.

    Attributes
    ----------
    step_weight : bool; the longer path has the weight of the step
    suffix_weight : bool; and the suffix its W
    target_of_suffix : bool; the longer path is weighted as if it began at x_(v+1)
    ends_compete : bool; paths that end at the next vertex
    nulls_count : bool; M of paths without light, when drawn
    averaged : bool; two candidates are counted, and divided by
    kept_by : 'sum', 'sum before' or 'turned'; how u decides
    stored : 'all', 'useful', 'joined' or 'any roughness'; who is put into a cell
    joint_asked : bool; a suffix that cannot be joined is a null
    null_confidence : bool; M of nulls in a cell
    held : str; as what W and M are stored in a cell, by its name in `HALVES`
    reach : 'at most', 'below' or 'any'; the last point
    from_v : bool; the bounces before the vertex count
    """

    step_weight: bool = True
    suffix_weight: bool = True
    target_of_suffix: bool = False
    ends_compete: bool = True
    nulls_count: bool = True
    averaged: bool = False
    kept_by: str = "sum"
    stored: str = "all"
    joint_asked: bool = True
    null_confidence: bool = True
    held: str = "exact"
    reach: str = "at most"
    from_v: bool = True


@dataclass(frozen=True, slots=True)
class GridRules:
    """What the passes calculate with."""

    cell: CellRules = field(default=CellRules())
    words: HashRules = field(default=HashRules())
    table: TableRules = field(default=TableRules())
    light: LightRules = field(default=LightRules())
    suffix: SuffixRules = field(default=SuffixRules())


CONTRACT_GRID = GridRules()


def whole_setting(case: Case, name: str, most: int) -> int:
    """A setting that is a whole number from 1 on, as far as anybody takes it.

    The diagnosis asks what would be right if it were 0, or without limit.
    """
    return int(min(max(float(case.settings[name]), 1.0), most))


def gridded(rules: Rules) -> GridRules:
    """What the passes calculate with."""
    found: GridRules = rules.part or CONTRACT_GRID
    return found
