"""The check of built pages, on pages of its own."""

import pytest

from tests.contracts.pages import faults


@pytest.fixture
def site(tmp_path):
    def write(**pages):
        for name, body in pages.items():
            (tmp_path / f"{name}.html").write_text(f"<html><body>{body}</body></html>")
        (tmp_path / "own.css").write_text("")
        return tmp_path

    return write


def test_a_whole_site_has_no_faults(site):
    folder = site(
        a='<link rel="stylesheet" href="own.css"><a href="b.html#here">b</a>'
        '<a href="https://elsewhere.org">a link is not fetched</a>'
        '<link rel="canonical" href="https://elsewhere.org/a.html">',
        b='<p id="here"></p><a href="#here">up</a><img src="data:image/png;base64,">',
    )
    assert list(faults(folder)) == []


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ('<script src="https://cdn.org/x.js"></script>', "fetches https://cdn.org"),
        ('<img src="//cdn.org/x.png">', "fetches //cdn.org"),
        ('<link rel="stylesheet" href="gone.css">', "wants gone.css"),
        ('<a href="gone.html">x</a>', "leads to gone.html"),
        ('<a href="a.html#nowhere">x</a>', "no such place"),
        ('<a href="#nowhere">x</a>', "no such place"),
    ],
)
def test_control_each_fault_is_told(site, body, told):
    (found,) = faults(site(a=body))
    assert told in found
