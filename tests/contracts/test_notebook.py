"""``restir_gi.reference.notebook``: a verdict as a notebook shows it."""

import json
import re
from base64 import b64decode

import numpy as np
import pytest

from restir_gi.reference.notebook import check
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.system.errors import UsageError
from tests.mutants.catalogue import JACOBIANS
from tests.mutants.harness import Planted

PASSES = ("jacobian", "spatial")


@pytest.fixture(scope="module")
def right():
    return check(BuiltIn("float32"), only=PASSES)


@pytest.fixture(scope="module")
def wrong():
    return check(Planted(JACOBIANS[0]), only=PASSES)


def test_what_is_right_is_one_line_and_a_table(right):
    assert repr(right).startswith("<PASS: BuiltIn: all that was asked is right")
    assert "\n" not in repr(right)
    shown = right._repr_html_()
    assert shown.count("<tr>") == 1 + len(PASSES)
    assert "<img" not in shown


def test_what_is_wrong_is_named_and_pictured(wrong):
    assert wrong.status == "FAIL"
    assert "spatial is wrong" in repr(wrong)
    shown = wrong._repr_html_()
    assert shown.count("<tr>") == 1 + len(PASSES)
    pictures = re.findall('base64,([^"]+)"', shown)
    assert pictures
    for picture in pictures:
        assert b64decode(picture).startswith(b"\x89PNG")


def test_what_a_backend_is_called_cannot_steer_the_page():
    class Renamed(BuiltIn):
        pass

    Renamed.__name__ = "<script>"
    found = check(Renamed("float32"), only=["jacobian"])
    assert "<script>" not in found._repr_html_()


def test_the_dict_is_what_the_report_has(wrong, tmp_path):
    wrong.save(tmp_path / "report")
    read = json.loads((tmp_path / "report" / "verdict.json").read_text("utf-8"))
    assert read == json.loads(json.dumps(wrong.to_dict()))
    assert (tmp_path / "report" / "index.html").exists()


def test_a_page_alone(wrong, tmp_path):
    wrong.save(tmp_path / "page.html")
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]
    with pytest.raises(UsageError):
        wrong.save(tmp_path / "nowhere" / "page.html")


# ---------------------------------------------------------------- other arrays


class OfAnotherLibrary:
    """An array that says by DLPack alone what it holds."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self, **kwargs):
        return self.array.__dlpack__(**kwargs)

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


class OnADevice:
    """An array that has to be copied to be read."""

    def __init__(self, array):
        self.array = array

    def __dlpack_device__(self):
        return (2, 0)

    def get(self):
        """On the host."""
        return self.array


class Stuck(OnADevice):
    """One that cannot."""

    get = None


def answering(kind):
    class Converting:
        def jacobian(self, **inputs):
            found = BuiltIn("float32").jacobian(**inputs)
            return {n: kind(np.asarray(a)) for n, a in found.items()}

    return Converting()


@pytest.mark.parametrize("kind", [OfAnotherLibrary, OnADevice, list])
def test_arrays_of_other_libraries_are_read(kind):
    assert check(answering(kind), only=["jacobian"]).status == "PASS"


def test_control_an_array_that_cannot_be_copied_fails():
    found = check(answering(Stuck), only=["jacobian"])
    assert found.status == "FAIL"
    assert "is on a device" in str(found.to_dict())
