"""What shifts of paths are replayed with: the contract, or a known mistake."""

from collections.abc import Callable
from dataclasses import dataclass

from restir_gi.extensions.oracle.shifts.formulas import perceptual, spread
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.rules import Rules


@dataclass(frozen=True, slots=True)
class ShiftRules:
    """What the passes of shifts calculate with.

    Attributes
    ----------
    perceptual : callable; roughness of a GGX width
    ends : tuple of int; of the two points, which have to be rough: 0 and 1
    one_end_is_enough : bool; one rough point of the two suffices
    single_asked : bool
        Whether points that scatter into single directions alone are refused.
    distance_asked : bool; whether points have to be far apart
    metres : bool; the least distance is taken for metres
    spread : callable; solid angle of an area, of base path and offset path
    spread_to : callable or None; of the offset path alone, where it is another
    inverted : bool; the Jacobian is upside down
    jacobian_omitted : bool; it is 1
    left_density, onward_density : bool
        Whether the first and the second density are in the Jacobian.
    offset_left, offset_onward : bool
        Whether those of the offset path are, where the base path's are.
    chosen_density : bool
        The density at x_c is divided by, and in it, although the light was chosen.
    earlier_asked : bool; whether offset paths that could be joined earlier are refused
    before_asked : bool; whether that holds for the point before the joint
    joint_asked : bool; whether the criterion is asked where the paths are joined
    delta_left_asked, delta_came_asked : bool
        Whether a point that is left, or reached, by a delta lobe is no joint.
    end_asked : bool; whether a replayed path that could be joined at its end is refused
    hits_asked : bool; whether paths of other lengths are refused
    visibility_asked, horizon_asked : bool; at the joint
    bases_distance, bases_value : bool
        What the base path had is taken for what the offset path has.
    throughput : 'offset', 'base', 'last' or 'none'
        Whose, up to the joint; 'last': the last weight of the offset path's alone.
    end_throughput : 'offset', 'last' or 'none'
        The same of paths that are replayed whole.
    replayed_over_density : bool
        The Jacobian of those is divided by a density that they do not have.
    share : 'offset', 'base', 'other', 'choice' or 'none'
        Whose share of the technique; 'other': that of the other technique; 'choice':
        of next-event estimation for both.
    replayed_once_more : int; vertices that are replayed beyond x_(c-1)
    replays_asked : bool
        Whether only joints at x_2 are shifted, where nothing else is asked for.
    last_asked : bool; whether there is a last joint
    """

    perceptual: Callable[[Bounded], Bounded] = perceptual
    ends: tuple[int, ...] = (0, 1)
    one_end_is_enough: bool = False
    single_asked: bool = True
    distance_asked: bool = True
    metres: bool = False
    spread: Callable[[Bounded, Bounded], Bounded] = spread
    spread_to: Callable[[Bounded, Bounded], Bounded] | None = None
    inverted: bool = False
    jacobian_omitted: bool = False
    left_density: bool = True
    onward_density: bool = True
    offset_left: bool = True
    offset_onward: bool = True
    chosen_density: bool = False
    earlier_asked: bool = True
    before_asked: bool = True
    joint_asked: bool = True
    delta_left_asked: bool = True
    delta_came_asked: bool = True
    end_asked: bool = True
    hits_asked: bool = True
    visibility_asked: bool = True
    horizon_asked: bool = True
    bases_distance: bool = False
    bases_value: bool = False
    throughput: str = "offset"
    end_throughput: str = "offset"
    replayed_over_density: bool = False
    share: str = "offset"
    replayed_once_more: int = 0
    replays_asked: bool = True
    last_asked: bool = True


def shifting(rules: Rules) -> ShiftRules:
    """What the passes of shifts calculate with."""
    return rules.part or ShiftRules()
