"""The page that leads from the papers' numbers to code, tests and figures.

``python -m tests.contracts.traceability`` writes it anew.
"""

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
TABLE = Path(__file__).with_name("traceability.toml")
PAGE = ROOT / "docs" / "reference" / "traceability.md"

INTRODUCTION = """\
# From the papers to the code

<!-- Written by tests.contracts.traceability; a test compares. -->

Every numbered equation and algorithm of the three papers, the function that it became,
a test that fails where it is something else, and a figure or lesson in which it is
seen. That the test fails is itself tested: each row has lines of that function, written
wrongly, on which it does. What the papers leave open or state wrongly stands in
[Errata](../explanation/errata.md).
"""


def entries():
    """Papers, and the rows of each."""
    table = tomllib.loads(TABLE.read_text("utf-8"))
    return table["papers"], {name: table[name] for name in table["papers"]}


def module_link(code):
    module, name = code.split(":")
    return f"`{module}.{name}`"


def seen_link(seen):
    if seen.startswith("lesson "):
        step = seen.removeprefix("lesson ")
        (page,) = (ROOT / "docs" / "lessons").glob(f"plot_{step}_*.py")
        return f"[{seen}](../auto_lessons/{page.stem})"
    found = [
        page.stem
        for page in (ROOT / "docs" / "gallery").glob("plot_*.py")
        if page.stem.split("_", 2)[2].lstrip("0123456789_") == seen.replace("-", "_")
    ]
    return f"[{seen}](../auto_gallery/{found[0]})" if found else seen


def page():
    papers, rows = entries()
    parts = [INTRODUCTION]
    for name, paper in papers.items():
        parts.append(f"\n## {paper['title']} [{name}]\n\n")
        parts.append("| number | what it says | code | test | seen in |\n")
        parts.append("|---|---|---|---|---|\n")
        for number, row in rows[name].items():
            test = row["test"].replace("tests/", "").replace("::", " ")
            parts.append(
                f"| {number} | {row['what']} | {module_link(row['code'])} |"
                f" `{test}` | {seen_link(row['seen'])} |\n"
            )
    return "".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
