"""Pages that commands write: everybody can read them, and they need nothing else."""

import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.reports.verdict.page import write_page
from restir_gi.reference.reports.verdict.plain import as_plain
from tests.browser.accessible import overflow, violations
from tests.mutants.catalogue import BY_NAME
from tests.mutants.harness import Planted

MISTAKE = "the weight is divided by the Jacobian"


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """A verdict on a wrong backend, a comparison, and a sweep."""
    folder = tmp_path_factory.mktemp("pages")
    verdict = judge(Planted(BY_NAME[MISTAKE]), 120.0, statistics=False)
    write_page(
        folder / "verdict", verdict, as_plain(verdict, MISTAKE, whole_contract())
    )
    for name in ("biased", "unbiased"):
        out, method = str(folder / f"{name}.exr"), f"restir-gi-{name}"
        how = ("--method", method, "--size", "32x32", "--frames", "2")
        assert main(["render", "cornell-box", *how, "--out", out]) == 0
    two = [str(folder / f"{name}.exr") for name in ("biased", "unbiased")]
    assert main(["compare", *two, "--out", str(folder / "compare")]) == 0
    few = ("--sweep", "radius=0.05,0.1", "--design", "0", "--runs", "3")
    short = ("--size", "16x16", "--frames", "2", "--spp", "4")
    sweep = ("tradeoff", "cornell-box", "--out", str(folder / "sweep"))
    assert main([*sweep, *few, *short]) == 0
    return folder


@pytest.mark.parametrize("name", ["verdict", "compare", "sweep"])
@pytest.mark.parametrize(("width", "scheme"), [(320, "light"), (1280, "dark")])
def test_everybody_can_read_it(pages, visit, name, width, scheme):
    page = visit(pages / name / "index.html", width=width, scheme=scheme)
    assert violations(page) == {}
    assert overflow(page) == 0
    assert page.complaints == []
    assert [url for url in page.fetched if not url.startswith(("file:", "data:"))] == []
