"""Known mistakes with the domain of shifts of paths."""

from restir_gi.extensions.oracle.shifts.rules import ShiftRules
from restir_gi.reference.oracle.diagnosis.hypothesis import mistake

SHIFT = ("shift",)
BOTH_WAYS = "refused where the offset path could be joined before x_c"

DOMAINS = (
    mistake(
        "earlier-joints-accepted",
        "offset paths that could be joined earlier are accepted",
        "the offset path is not asked before x_c",
        BOTH_WAYS,
        SHIFT,
        "gradientdomain-mitsuba 7f01a2c",
        part=ShiftRules(earlier_asked=False, before_asked=False, end_asked=False),
    ),
    mistake(
        "earlier-joints-accepted-but-at-the-last",
        "offset paths are asked at their last point alone",
        "came_v is not asked for v < m",
        BOTH_WAYS,
        SHIFT,
        part=ShiftRules(earlier_asked=False),
    ),
    mistake(
        "joint-before-accepted",
        "offset paths that could be joined at x_(c−1) are accepted",
        "came_v is asked for v < c − 1",
        BOTH_WAYS,
        SHIFT,
        part=ShiftRules(before_asked=False),
    ),
    mistake(
        "joint-at-the-end-accepted",
        "paths that are replayed whole are accepted although x_end could be joined",
        "came_v is asked for v < end",
        "came_v is asked for v = end too",
        SHIFT,
        part=ShiftRules(end_asked=False),
    ),
    mistake(
        "bases-joint-not-asked",
        "the joint of the base path need not be one of the offset path",
        "joinable of x_(c−1) and x_c is not asked",
        "joinable of x_(c−1) and x_c is 1",
        SHIFT,
        part=ShiftRules(joint_asked=False),
    ),
    mistake(
        "delta-left-is-no-joint-forgotten",
        "points that are left by a delta lobe count as joints",
        "came_v is 0 for v ≤ m",
        "came_v is 0, or delta_v 1, for v < m, and at m of a replayed emitter hit",
        SHIFT,
        part=ShiftRules(delta_left_asked=False),
    ),
    mistake(
        "delta-came-is-a-joint",
        "points that are reached by a delta lobe count as joints",
        "came_v does not ask delta_(v−1)",
        "came_v = 0 where delta_(v−1) is 1",
        SHIFT,
        part=ShiftRules(delta_came_asked=False),
    ),
    mistake(
        "path-length-not-asked",
        "offset paths that are shorter are accepted",
        "hit_v is not asked",
        "refused where hit_v is 0 for any v ≤ m",
        SHIFT,
        part=ShiftRules(hits_asked=False),
    ),
    mistake(
        "hidden-joint-accepted",
        "whether the joint is seen is not asked, or asked from the base path",
        "seen is not asked",
        "refused where seen is 0",
        SHIFT,
        "gradientdomain-mitsuba 4f517e4",
        part=ShiftRules(visibility_asked=False),
    ),
    mistake(
        "joint-seen-from-behind",
        "the joint may be on the other side of the surface",
        "joint_normal · D is not asked",
        "refused where joint_normal · D ≥ 0",
        SHIFT,
        part=ShiftRules(horizon_asked=False),
    ),
    mistake(
        "replays-not-asked",
        "paths without a joint at x_2 are replayed, where only such are shifted",
        "replays is not asked",
        "refused where replays is 0 and c ≠ 2",
        SHIFT,
        part=ShiftRules(replays_asked=False),
    ),
)
