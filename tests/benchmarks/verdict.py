"""The terminal in the README: the verdict on a backend that divides by the Jacobian.

    python -m tests.benchmarks.verdict [OUT.svg]

The passes are the project's own in single precision, with one mistake.
"""

import re
import sys
from io import StringIO
from pathlib import Path

from rich.console import Console

from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.reports.verdict.plain import as_plain
from restir_gi.reference.reports.verdict.table import table
from tests.mutants.catalogue import JACOBIANS
from tests.mutants.harness import Planted

PICTURE = Path(__file__).parents[2] / "docs" / "_static" / "verdict.svg"
NAME = "./my-shaders {directory}"


MISTAKE = next(
    m for m in JACOBIANS if m.name == "the weight is divided by the Jacobian"
)


def main() -> None:
    verdict = judge(Planted(MISTAKE), 600.0, statistics=False)
    plain = as_plain(verdict, NAME, whole_contract())
    console = Console(record=True, width=100, file=StringIO(), highlight=False)
    console.print(f"$ restir check '{NAME}' --out report", markup=False)
    console.print(table(plain))
    picture = console.export_svg(title="restir check")
    # Without the fonts that it would fetch.
    picture = re.sub(r"@font-face \{.*?\}\n", "", picture, flags=re.DOTALL)
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE
    out.write_text(picture, "utf-8")


if __name__ == "__main__":
    main()
