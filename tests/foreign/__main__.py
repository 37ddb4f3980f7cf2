"""Table of foreign backends: what is true of them, and what the verdict says.

    python -m tests.foreign [WORD ...]

Words choose backends by their names.
"""

import sys
import time

from restir_gi.reference.oracle.checking import judge
from tests.foreign.backends import FOREIGN

WANTED = {"right": "PASS", "wrong": "FAIL", "extremes": "PASS", "declared": "FAIL"}


def bias_of(foreign):
    """The largest bias by enumeration, in words."""
    found = foreign.bias()
    if found is None:
        return f"shown at {foreign.elsewhere}"
    where, bias = found
    return f"{100 * bias.relative:+.4f} % in {where}"


def row_of(foreign):
    """A row of the table, and whether the verdict is what it should be."""
    truth = bias_of(foreign)
    start = time.monotonic()
    verdict = judge(foreign.backend, budget=600.0, statistics=False)
    seconds = time.monotonic() - start
    names = {h.name: None for d in verdict.diagnoses for h in d.matches}
    right = verdict.status == WANTED[foreign.kind]
    mark = "" if right else f", and {WANTED[foreign.kind]} is true"
    cells = (
        foreign.name,
        foreign.kind,
        truth,
        verdict.status + mark,
        ", ".join(names) or "none",
        f"{seconds:.1f}",
    )
    return "| " + " | ".join(cells) + " |", right


def main(words):
    """Write the table."""
    say("| backend | kind | largest bias | verdict | named | s |")
    say("|---|---|---|---|---|---|")
    judged = []
    for foreign in FOREIGN:
        if not words or any(word in foreign.name for word in words):
            row, right = row_of(foreign)
            judged.append(right)
            say(row)
    say(f"\n{sum(judged)} of {len(judged)} verdicts are true.")


def say(line):
    """Write a line, at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
