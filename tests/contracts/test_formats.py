"""The page of formats is what the loaders' tables say, and the tables are whole."""

from pathlib import Path

import pytest

from restir_gi.reference.scene.loaders.formats import (
    TABLES,
    formats_page,
    words_of_format,
)
from restir_gi.reference.scene.loaders.load import LOADERS
from restir_gi.reference.scene.loaders.words import Use

PAGE = Path(__file__).parents[2] / "docs/reference/formats.md"


def test_the_page_is_what_the_tables_say(regenerate):
    if regenerate:
        PAGE.write_text(formats_page())
    assert PAGE.read_text() == formats_page()


def test_control_a_page_of_another_table_is_not_the_page():
    assert formats_page() != formats_page().replace("`Kd`", "`Ks`", 1)


def test_every_format_that_loads_is_on_the_page():
    told = " ".join(TABLES)
    assert all(suffix in told for suffix in LOADERS)


@pytest.mark.parametrize("title", TABLES)
def test_a_word_stands_once_and_says_what_replaces_it(title):
    words = words_of_format(title)
    places = [(word.element, word.name) for word in words]
    assert len(set(places)) == len(places)
    mute = [w.name for w in words if w.use is Use.REPLACED and not w.remark]
    assert not mute
