"""Pages that commands write: everybody can read them, and they need nothing else."""

import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.reports.pictures.page import write_page as write_pictures
from restir_gi.reference.reports.pictures.plain import as_plain as plain_pictures
from restir_gi.reference.reports.verdict.page import write_page
from restir_gi.reference.reports.verdict.plain import as_plain
from tests.browser.accessible import cut_off, overflow, violations
from tests.contracts.synthetic_pictures import judged, light, pictures_of
from tests.mutants.catalogue import BY_NAME
from tests.mutants.harness import Planted

MISTAKE = "the weight is divided by the Jacobian"
LONG = f"./{'renderer' * 12} --scene {{scene}} --seed {{seed}} --out {{out}}"


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Verdicts on a wrong backend and on wrong pictures, a comparison, and a sweep."""
    folder = tmp_path_factory.mktemp("pages")
    verdict = judge(Planted(BY_NAME[MISTAKE]), 120.0, statistics=False)
    write_page(
        folder / "verdict", verdict, as_plain(verdict, MISTAKE, whole_contract())
    )
    wrong = judged(pictures_of(1.1 * light(), 100))
    write_pictures(folder / "pictures", wrong, plain_pictures(wrong, LONG, 12.5))
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


@pytest.mark.parametrize("name", ["verdict", "pictures", "compare", "sweep"])
@pytest.mark.parametrize(("width", "scheme"), [(320, "light"), (1280, "dark")])
def test_everybody_can_read_it(pages, visit, name, width, scheme):
    page = visit(pages / name / "index.html", width=width, scheme=scheme)
    assert violations(page) == {}
    assert overflow(page) == 0
    assert page.complaints == []
    assert [url for url in page.fetched if not url.startswith(("file:", "data:"))] == []


@pytest.mark.parametrize("name", ["verdict", "pictures"])
@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_of_a_verdict_is_cut_off(pages, visit, width, name):
    """Nor of what is folded: inputs of neighbours, all faults, passes and tiles."""
    page = visit(pages / name / "index.html", width=width)
    assert cut_off(page) == []
    assert overflow(page) == 0
    assert violations(page) == {}


def test_control_what_is_cut_off_is_found(pages, visit):
    page = visit(pages / "verdict" / "index.html", width=390)
    wide = "<div style='overflow: hidden; width: 9rem'><p style='width: 12rem'>x</p>"
    page.evaluate("wide => document.body.insertAdjacentHTML('beforeend', wide)", wide)
    assert len(cut_off(page)) == 1


def test_the_first_wrong_pass_leads_a_verdict(pages, visit):
    """One sentence; its numbers are open, and all that is right is folded."""
    page = visit(pages / "verdict" / "index.html")
    lead = page.locator(".lead").inner_text()
    assert " is wrong" in lead or " is too " in lead
    first = page.locator("main > :first-child")
    assert first.evaluate("e => e.tagName") == "SECTION"
    table = first.locator("table").first
    assert table.is_visible()
    assert table.locator("th", has_text="Expected").is_visible()
    folded = page.locator("main > details > summary").all_inner_texts()
    assert any(text.startswith("All passes: ") for text in folded)
    assert any(text.startswith("All steps: ") for text in folded)
    assert not page.locator("main > details[open]").count()


def test_the_page_of_a_mistake_is_in_the_report(pages, visit):
    page = visit(pages / "verdict" / "index.html")
    page.locator("a[href^='#mistake-']").first.click()
    place = page.url.partition("#")[2]
    assert page.locator(f"#{place}").is_visible()
    assert "Right" in page.locator(f"#{place}").inner_text()
    assert page.complaints == []
