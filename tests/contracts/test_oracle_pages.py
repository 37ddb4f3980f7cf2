"""Pages of the documentation that are written from the code."""

from pathlib import Path

import pytest

from restir_gi.reference.oracle.capture.describe import describe as capture_page
from restir_gi.reference.oracle.contract.describe import describe as contract_page
from restir_gi.reference.oracle.declaration.describe import (
    describe as declaration_page,
)
from restir_gi.reference.oracle.declaration.schema import written_schema
from restir_gi.reference.oracle.diagnosis.describe import describe as bugs_page
from restir_gi.reference.oracle.diagnosis.diagnose import known_mistakes
from restir_gi.reference.oracle.parts import whole_contract

CONTRACT = whole_contract()

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {
    "reference/capture.md": capture_page,
    "reference/contract.md": lambda: contract_page(CONTRACT),
    "explanation/bugs.md": lambda: bugs_page(known_mistakes()),
    "reference/declaration.md": lambda: declaration_page(CONTRACT),
    "../reference/oracle/declaration/declaration.schema.json": written_schema,
}


@pytest.mark.parametrize("name", PAGES)
def test_the_page_is_what_the_code_says(name, regenerate):
    path, text = DOCS / name, PAGES[name]()
    if regenerate:
        path.write_text(text, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == text


def test_every_pass_tells_all_buffers_that_are_always_given():
    """Also one that has the name of a buffer of declared surfaces."""
    sections = contract_page(CONTRACT).split("\n## ")
    for one in CONTRACT.values():
        (section,) = (s for s in sections if s.startswith(f"`{one.name}`"))
        given = [field.name for field in one.inputs if field.only is None]
        assert [name for name in given if f"| in | `{name}` |" not in section] == []


def test_names_are_anchors():
    names = [h.name for h in known_mistakes()]
    assert len(set(names)) == len(names)
    assert all(name == name.lower() and " " not in name for name in names)


def test_every_hypothesis_names_passes_of_the_contract():
    for h in known_mistakes():
        assert set(h.passes) <= set(CONTRACT)
