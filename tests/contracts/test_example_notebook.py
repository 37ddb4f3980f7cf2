"""The notebook of the examples, run as whoever opens it runs it."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOK = (
    Path(__file__).parents[2]
    / "docs"
    / "examples"
    / "notebook"
    / "check_a_backend.ipynb"
)


@pytest.fixture(scope="module")
def cells(tmp_path_factory):
    """Its cells by their names, run in a folder of their own."""
    folder = tmp_path_factory.mktemp("notebook")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    about = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, timeout=300, resources=about).execute()
    assert (folder / "verdict.html").exists()
    return {cell.id: cell for cell in notebook.cells}


def shown(cell):
    """What the notebook shows of the last line."""
    (output,) = (o for o in cell.outputs if o.output_type == "execute_result")
    return output.data


def test_what_is_wrong_is_a_table_and_pictures(cells):
    found = shown(cells["check"])
    assert "<b>FAIL</b>" in found["text/html"]
    assert found["text/html"].count("<tr>") == 3
    assert "data:image/png;base64" in found["text/html"]
    assert found["text/plain"].startswith("<FAIL: MyBackend: ")


def test_what_is_mended_passes(cells):
    found = shown(cells["mended"])
    assert "<b>PASS</b>" in found["text/html"]
    assert cells["keep"].outputs[0].text == "PASS\n"


def test_nothing_is_stored_that_was_shown():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
