"""Text of others is shown on a terminal, and cannot steer it."""

import io
import json
import sys

import pytest
from rich.table import Table

from restir_gi.reference.cli import console
from restir_gi.reference.cli.main import main
from restir_gi.reference.system.terminal import visible

EVIL = "\x1b[2J\x1b]0;title\x07kit\x9bchen\u202e\r\x00[red]x[/blue]"
SCENE = {
    "camera": {"origin": [0.2, 0.2, 2], "target": [0.2, 0.2, 0], "fov_deg": 40},
    "materials": {"grey": {"type": "diffuse", "reflectance": 0.5}},
    "shapes": [{"id": "ball", "type": "sphere", "center": [0.2, 0.2, 0],
                "radius": 0.2, "material": "grey"}],
    "lights": [{"type": "constant", "radiance": 1}],
}  # fmt: skip


def harmless(text):
    """No character but line breaks that is not printed as it is."""
    return text.replace("\n", "").isprintable()


def test_control_the_text_is_evil():
    assert not harmless(EVIL)
    assert harmless(visible(EVIL))
    assert visible("Küche 3 µm") == "Küche 3 µm"
    assert visible("a\nb") == r"a\nb"
    assert visible("a\nb\x07", keep="\n") == "a\nb\\x07"


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self):
        """Say so."""
        return True


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_lines_and_tables(monkeypatch, stream):
    """Also on a terminal, where headings have colours of their own."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stdout", stream())
    table = Table(EVIL, title=EVIL, caption=EVIL)
    table.add_row(EVIL)
    console.show(table)
    console.show(EVIL)
    text = sys.stdout.getvalue()
    for wanted in (r"\x1b[2J", r"\x9b", r"\u202e", "[red]x[/blue]"):
        assert wanted in text
    for evil in ("\x1b[2J", "\x1b]0", "\x9b", "\x07", "\u202e", "\x00"):
        assert evil not in text
    assert harmless(text) == (stream is io.StringIO)


def test_remarks_and_progress(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", Terminal())
    console.remark(EVIL)
    with console.progress(EVIL) as tick:
        tick(1, 2, EVIL)
    text = sys.stderr.getvalue()
    assert r"restir: \x1b[2J" in text
    for evil in ("\x1b[2J", "\x1b]0", "\x9b", "\x07", "\u202e"):
        assert evil not in text


def test_the_name_of_a_scene(tmp_path, capsys):
    """A name in a file reaches results, remarks, errors and JSON."""
    path, out = tmp_path / "evil.json", str(tmp_path / "x.exr")
    scene = SCENE | {"name": EVIL, EVIL: 1}
    path.write_text(json.dumps(scene))
    small = ["--method", "path", "--spp", "1", "--size", "4x4", "--out", out]
    assert main(["render", str(path), "--frame", EVIL, *small]) == 2
    assert harmless(capsys.readouterr().err)
    assert main(["render", str(path), *small]) == 0
    written = capsys.readouterr()
    assert r"\x1b[2J" in written.out
    assert harmless(written.out)
    assert harmless(written.err)
    assert main(["render", str(path), "--json", *small]) == 0
    written = capsys.readouterr()
    assert harmless(written.out)
    assert json.loads(written.out)["metadata"]["scene"] == EVIL
    assert main(["compare", out, out]) == 0
    assert harmless(capsys.readouterr().out)
