"""The kill matrix: which level sees which mistake, and what it is called.

From the root of the checkout, in some four minutes::

    python -m tests.mutants.matrix --out docs/explanation/kill_matrix.md
"""

import argparse
from collections import Counter
from pathlib import Path

from scipy.stats import beta

from tests.mutants import hash_grid, pairs
from tests.mutants.catalogue import MUTANTS
from tests.mutants.further import FURTHER_MUTANTS
from tests.mutants.harness import ASIDE, EXACT, Kill, kill
from tests.mutants.hash_grid import HASH_GRID_MUTANTS
from tests.mutants.held_out import HELD_OUT
from tests.mutants.pairs import PAIR_MUTANTS
from tests.mutants.reuse import REUSE_MUTANTS
from tests.mutants.shifts import SHIFT_MUTANTS

INTRODUCTION = """\
# Kill matrix

<!-- Written by tests.mutants.matrix. -->

Mistakes that renderers made, planted one at a time in the built-in single-precision
backend, and judged by the ladder without statistics. "First" is the level that sees
it first, with the seconds until then on one core; "named" says whether the diagnosis
gave the right name for every pass that it named. A mistake that keeps the distribution
of the estimate, or its expectation, is no bias: where it is a
[departure](oracle.md#departures) that is known, it is named and passes.
"""

KNOWN = """
## The catalogue of bugs

Most of the known mistakes were written down after these were planted, and some cases
made for them: so the shares are no estimate of how a mistake fares that nobody has
thought of; [planted blind](#planted-blind), 90 % are killed and 33 % of these named.
Before that, 99 of the first 101 biases were killed and 51 named rightly.
"""

FURTHER = """
## Around the resampling

The passes from `gbuffer` to `unpack`. The mistakes were planted before the known ones
were written down; three names were put right afterwards.
"""

SHIFTS = """
## Shifts of whole paths

The passes `joinable`, `path_jacobian` and `shift`. Mistakes and names were written down
together; some names were added for mistakes that had none.
"""

REUSE = """
## Reuse of whole samples

The pass `path_reuse`. Mistakes and names were written down together.
"""

GRID = """
## Hash grid

The passes from `cell_level` to `suffix_reach`. Mistakes and names were written down
together.
"""

PAIRS = """
## Pairs of paths, and images made from differences

The passes from `pair_value` to `poisson_l1`. Mistakes and names were written down
together.
"""

UNSEEN = """
## Held out

Mistakes by somebody who had not seen the oracle, its cases or its names, and who was
asked for ones that differ from those above. Oracle and cases were not changed after
they were judged; the three names that came out were then found to be right. What is
killed is an estimate of how a mistake fares that nobody has thought of. A name can
only be given to what is known. The survivors are in rays, paths and the loop of
frames, which backends are given as data or have to themselves: pictures show them,
and no pass does.
"""

BLIND = """
## Planted blind

Into a backend of all passes, written in single precision from the contract alone,
somebody who did not know the cases planted 71 biases: 64 were killed (90 %, 95 %
interval 81 % to 96 %). Of the 64 the diagnosis named 21 (33 %), and none wrongly.
The 7 survivors are clauses and settings that no case exercises: one positive density
in all cases of `initial`, a density of light that is never 0, a confidence that
never reaches its cap. These mistakes are not kept with the tests, so that nothing
measures this again.

After the cases were made to go everywhere, 40 others were planted in the same way. They
are kept (`tests/mutants/blind.py`): 38 are killed, all 38 under a right name or in
words that tell the term, and two that bring no bias are told as departures.
"""


def interval(successes: int, trials: int) -> tuple[float, float]:
    """Clopper and Pearson's 95 % interval of a proportion."""
    low = beta.ppf(0.025, successes, trials - successes + 1) if successes else 0.0
    high = beta.ppf(0.975, successes + 1, trials - successes)
    return float(low), float(high) if successes < trials else 1.0


def page(groups: dict[str, list[Kill]]) -> str:
    """The page, from what was found, by what is said of it."""
    judged = "".join(
        text + _totals(kills) + _table(kills) for text, kills in groups.items()
    )
    return INTRODUCTION + judged + BLIND


def _totals(kills: list[Kill]) -> str:
    bias = [k for k in kills if k.mutant.kind == "bias"]
    dead = [k for k in bias if k.killed]
    low, high = interval(len(dead), len(bias))
    named = Counter(k.named for k in dead)
    alone = Counter(k.levels[0] for k in dead if len(k.levels) == 1)
    slowest = max(k.total for k in kills)
    lines = [
        f"\n- biases: {len(dead)} of {len(bias)} killed"
        f" ({len(dead) / len(bias):.0%}, 95 % interval {low:.0%} to {high:.0%});"
        f" all steps take {slowest:.1f} s at most",
        f"- named rightly: {named['right']} of {len(dead)}"
        f" ({named['right'] / len(dead):.0%}); right among others {named['several']};"
        f" no name {named['none']}; a wrong name alone {named['WRONG']}",
        "- killed by one level alone: "
        + ", ".join(f"{level} {n}" for level, n in sorted(alone.items())),
        "- survivors: " + (", ".join(_survivors(bias)) or "none"),
        *_equivalents([k for k in kills if k.mutant.kind == "equivalent"]),
    ]
    return "\n".join(lines) + "\n"


def _survivors(kills: list[Kill]) -> list[str]:
    return [k.mutant.name for k in kills if not k.killed]


def _equivalents(kills: list[Kill]) -> list[str]:
    if not kills:
        return []
    refused = [k.mutant.name for k in kills if k.killed]
    line = f"- equivalent: {len(kills) - len(refused)} of {len(kills)} pass"
    return [f"{line}; these do not: {', '.join(refused)}" if refused else line]


def _table(kills: list[Kill]) -> str:
    head = "\n| mistake | rows | kind | verdict | first | seen by | named |\n"
    return head + "|---|---|---|---|---|---|---|\n" + "".join(_row(k) for k in kills)


def _row(k: Kill) -> str:
    first = f"{k.levels[0]}, {k.seconds:.2f} s" if k.levels else "–"
    ids = ", ".join(k.mutant.ids)
    seen = " ".join(k.levels)
    named = k.named if k.levels else ""
    words = [k.mutant.name, ids, k.mutant.kind, k.status, first, seen, named]
    return f"| {' | '.join(words)} |\n"


def main() -> None:
    """Plant everything, and write the page."""
    parser = argparse.ArgumentParser(description="Write the kill matrix.")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.md")
    out = parser.parse_args().out
    kill(None, EXACT)  # makes the cases, so that the first mutant does not pay
    kill(None, EXACT, titles=ASIDE)
    core = {KNOWN: MUTANTS, FURTHER: FURTHER_MUTANTS, UNSEEN: HELD_OUT}
    aside = {
        SHIFTS: SHIFT_MUTANTS,
        REUSE: REUSE_MUTANTS,
        GRID: (*HASH_GRID_MUTANTS, *hash_grid.EQUIVALENT),
        PAIRS: (*PAIR_MUTANTS, *pairs.EQUIVALENT),
    }
    found = {text: [kill(m, EXACT) for m in group] for text, group in core.items()}
    for text, group in aside.items():
        found[text] = [kill(m, EXACT, titles=ASIDE) for m in group]
    out.write_text(page(found), encoding="utf-8")


if __name__ == "__main__":
    main()
