"""The frame of all pages: whole, escaped, and without need of anything else."""

import re

import pytest
from jinja2 import UndefinedError

from restir_gi.reference.reports.page import render_page
from tests.contracts.elements import Page

EVIL = "</script><script>alert(1)</script>\"'<img src=x>\udcff"
VALUES = {
    "title": EVIL,
    "remarks": [EVIL],
    "columns": ("a",),
    "rows": [(EVIL, (EVIL,))],
}


def demo(**changes):
    values = VALUES | changes
    return render_page("restir_gi.reference.reports.demo", "demo.html", values)


def test_what_is_told_cannot_break_out_of_the_page():
    page = Page(demo().decode("utf-8"))
    assert page.all("script") == []
    assert len(page.all("img")) == 1


def test_control_a_page_that_is_not_escaped_has_a_script():
    from markupsafe import Markup

    assert Page(demo(remarks=[Markup("<script></script>")]).decode()).all("script")


def test_a_name_without_utf_8_is_written_as_an_escape():
    assert rb"\udcff" in demo()


def test_a_value_that_is_forgotten_is_an_error():
    values = {name: value for name, value in VALUES.items() if name != "remarks"}
    with pytest.raises(UndefinedError, match="remarks"):
        render_page("restir_gi.reference.reports.demo", "demo.html", values)


def test_the_frame_names_its_maker_and_forbids_the_rest():
    page = Page(demo(title="cornell-box").decode())
    metas = {
        m.get("http-equiv") or m.get("name"): m.get("content") for m in page.all("meta")
    }
    assert metas["generator"] == "restir-gi-oracle"
    rules = dict(re.findall(r"([a-z-]+) ([^;]+)", metas["Content-Security-Policy"]))
    assert rules == {
        "default-src": "'none'",
        "style-src": "'unsafe-inline'",
        "img-src": "'self' file:",
    }
    assert page.all("html") == [{"lang": "en"}]
    assert len(page.all("main")) == len(page.all("header")) == 1
