"""Which passes are asked, that one case can be asked again, and what is kept."""

import json
import shlex
import time
from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.oracle.backends.offer import Offer, offer_of
from restir_gi.reference.oracle.backends.selected import SelectedBackend, Selection
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.cases import Case, for_ever
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.golden import read_golden
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.system.errors import UsageError

CONTRACT = whole_contract()
BACKENDS = Path(__file__).parent / "oracle_backends.py"

DARK = """
import numpy as np
from restir_gi.reference.oracle.builtin.backend import FLOAT32

class Dark:
    jacobian = staticmethod(FLOAT32.jacobian)

    def shade(self, **given):
        return {"color": FLOAT32.shade(**given)["color"] * np.float32(0.5)}

BACKEND = Dark()
"""


@pytest.fixture
def dark(tmp_path):
    """A backend of two passes, of which one is too dark."""
    path = tmp_path / "my dark.py"
    path.write_text(DARK, encoding="utf-8")
    return path


def run(capsys, *arguments):
    """Exit code, and the verdict."""
    code = main(["check", *map(str, arguments), "--json"])
    return code, json.loads(capsys.readouterr().out)


def refused(capsys, *arguments):
    """What is told of a wrong request."""
    assert main(["check", *map(str, arguments)]) == 2
    return capsys.readouterr().err


def asked(plain):
    """Names of the passes that were judged."""
    return {p["name"] for p in plain["passes"] if p["status"] != "not judged"}


# ---------------------------------------------------------------- one case


def test_a_failing_case_is_kept_and_can_be_asked_again(dark, tmp_path, capsys):
    keep = tmp_path / "kept"
    code, plain = run(capsys, dark, "--keep", keep)
    assert code == 1
    assert plain["first_wrong_pass"] == "shade"
    (case,) = [p["failing"] for p in plain["passes"] if p["name"] == "shade"]
    precision, probes = read_golden(keep)
    names = [probe.case.name for probe in probes]
    assert case["case"] in names
    assert {probe.case.pass_name for probe in probes} == {"shade"}
    assert precision == "float32"

    # The very rows: inputs, what was found, and what is right, stand in the folder.
    row = case["shown"][0]
    (probe,) = [p for p in probes if p.case.name == case["case"]]
    for name, value in row["inputs"].items():
        np.testing.assert_array_equal(probe.case.inputs[name][row["row"]], value)
    found = np.load(keep / case["case"] / "found.npz")["color"][row["row"]]
    np.testing.assert_array_equal(found, row["outputs"]["color"]["found"])
    right = np.load(keep / case["case"] / "expected.npz")["color"][row["row"]]
    np.testing.assert_allclose(right, row["outputs"]["color"]["expected"], rtol=1e-6)

    # The command that is printed asks for this case alone, and finds the same.
    program, _, *words = shlex.split(case["command"])
    assert program == "restir"
    assert words[:3] == [str(dark), "--against", str(keep)]
    code, again = run(capsys, *words)
    assert code == 1
    assert sum(step["asked"] for step in again["steps"]) == 1
    (same,) = [p["failing"] for p in again["passes"] if p["name"] == "shade"]
    assert same["shown"] == case["shown"]

    # A backend that is right in it passes what is kept.
    code, fixed = run(capsys, "float32", "--against", keep)
    assert (code, fixed["status"]) == (0, "PASS")


def test_a_case_is_asked_again_without_a_folder(dark, capsys):
    code, plain = run(capsys, dark, "--case", "kernel-shade", "--seed", "7")
    assert code == 1
    assert asked(plain) == {"shade"}
    (case,) = [p["failing"] for p in plain["passes"] if p["name"] == "shade"]
    told = f"restir check '{dark}' --seed 7 --case kernel-shade"
    assert case["command"] == told
    assert sum(step["asked"] for step in plain["steps"] if step["failed"]) > 0


def test_random_rows_are_new_with_another_seed(dark, capsys):
    def key(seed):
        about = ("--case", "kernel-shade", "--seed", seed)
        _, plain = run(capsys, dark, *about)
        (case,) = [p["failing"] for p in plain["passes"] if p["name"] == "shade"]
        return case["shown"][0]["inputs"]["position"]

    assert key(1) == key(1) != key(2)


def test_a_case_that_there_is_not_is_bad_usage(dark, tmp_path, capsys):
    keep = tmp_path / "kept"
    run(capsys, dark, "--case", "kernel-shade", "--keep", keep)
    about = (dark, "--against", keep, "--case", "kernel-shad")
    told = "unknown case 'kernel-shad'; did you mean kernel-shade?"
    assert told in refused(capsys, *about)
    assert "no case is called" in refused(capsys, dark, "--case", "kernel-shad")


def test_where_nothing_fails_nothing_is_kept(tmp_path, capsys):
    keep = tmp_path / "kept"
    about = (f"{BACKENDS}:PARTIAL", "--case", "kernel-shade", "--keep", keep)
    assert main(["check", *map(str, about)]) == 0
    assert "nothing is kept" in capsys.readouterr().err
    assert not keep.exists()


# ---------------------------------------------------------------- some passes


def test_passes_are_chosen_on_the_command_line(capsys):
    backend = f"{BACKENDS}:RIGHT"
    code, plain = run(capsys, backend, "--only", "jacobian,merge", "--skip", "random")
    assert (code, asked(plain)) == (0, {"jacobian", "merge"})
    assert plain["absent"] == []


def test_a_required_pass_that_is_absent_fails(dark, capsys):
    backend = dark.with_name("alone.py")
    backend.write_text(DARK.split("    def")[0] + "BACKEND = Dark()", encoding="utf-8")
    code, plain = run(capsys, backend, "--require", "jacobian,spatial")
    assert code == 1
    assert plain["headline"] == (
        "spatial is required, and the backend does not have it"
    )
    code, plain = run(capsys, backend, "--require", "jacobian")
    assert (code, plain["missing"]) == (0, [])


def test_a_required_pass_without_time_fails(capsys):
    code, plain = run(capsys, "float32", "--require", "shade", "--budget", "0")
    assert code == 1
    assert "no step that was taken judged it" in plain["headline"]


@pytest.mark.parametrize("option", ["--require", "--only", "--skip"])
def test_a_name_that_is_no_pass_is_bad_usage(option, capsys):
    told = refused(capsys, "float32", option, "shade,spatail")
    assert "unknown pass 'spatail'; did you mean spatial?" in told
    assert "comma between" in refused(capsys, "float32", option, "shade,")


def test_contradictions_are_bad_usage(capsys):
    both = ("float32", "--skip", "shade")
    assert "take one away" in refused(capsys, *both, "--only", "shade")
    assert "take one away" in refused(capsys, *both, "--require", "shade")
    renderer = "render {seed} {frames} {size} {out}"
    assert "--only is for passes" in refused(capsys, renderer, "--only", "shade")


def test_a_misspelt_pass_alone_fails(tmp_path, capsys):
    path = tmp_path / "mine.py"
    path.write_text("class B:\n    def jacobain(self): pass\nBACKEND = B()\n")
    code, plain = run(capsys, path)
    assert code == 1
    assert plain["near"] == [
        "jacobain is no pass of the contract; did you mean jacobian?"
    ]
    assert plain["headline"] == f"nothing was judged: {plain['near'][0]}"


# ---------------------------------------------------------------- what it has


class Remembering:
    """A program that has one pass, and remembers what it was asked."""

    precision = "float32"

    def __init__(self, *names):
        self.names, self.asked = names, []

    def run(self, passes, cases):
        """Outcome of each case."""
        self.asked += [case.name for case in cases]
        return [
            getattr(FLOAT32, c.pass_name)(**c.inputs, **c.settings)
            if c.pass_name in self.names
            else None
            for c in cases
        ]

    def remaining(self):
        """There is time."""
        return for_ever()

    def close(self):
        """Nothing is held."""
        return 0


def case(name, pass_name, **settings):
    """A case without rows."""
    return Case(name, pass_name, settings, {"W": np.zeros(0)})


def test_what_a_program_lacks_is_not_asked_again():
    """Unless a setting says another word: it may have that alone."""
    inner = Remembering()
    backend = SelectedBackend(inner)
    backend.run(CONTRACT, [case("a", "target", target="outgoing"), case("b", "shade")])
    assert backend.lacks("target", "shade")
    assert not backend.lacks("shade", "merge")
    backend.run(CONTRACT, [case("c", "shade"), case("d", "target", target="outgoing")])
    backend.run(CONTRACT, [case("e", "target", target="scattered")])
    assert inner.asked == ["a", "b", "e"]


def test_a_pass_that_left_out_one_case_is_asked_the_others():
    inner = Remembering("merge")
    backend = SelectedBackend(inner)
    questions = [p for p in kernel_cases() if p.pass_name == "merge"]
    inner.names = ()
    backend.run(CONTRACT, questions[:1])
    assert backend.lacks("merge")
    backend = SelectedBackend(inner)
    inner.names = ("merge",)
    backend.run(CONTRACT, questions[:1])
    inner.names, inner.asked = (), []
    backend.run(CONTRACT, questions[:1])
    backend.run(CONTRACT, questions[:1])
    assert not backend.lacks("merge")
    assert len(inner.asked) == 2


def kernel_cases():
    """Cases of the kernels."""
    from restir_gi.reference.oracle.levels.kernels import kernel_probes

    return [probe.case for probe in kernel_probes("float32")]


def test_one_case_of_all_is_asked():
    inner = Remembering("shade")
    backend = SelectedBackend(inner, Selection(case="kernel-shade"))
    found = backend.run(CONTRACT, kernel_cases())
    assert inner.asked == ["kernel-shade"]
    assert sum(outcome is not None for outcome in found) == 1
    assert not backend.lacks("shade")


def test_a_backend_of_one_kernel_takes_no_time_for_the_others():
    """The frames of five scenes and all relations were made for it once."""
    judge(FLOAT32, 60.0, statistics=False, selection=Selection(frozenset(["merge"])))
    start = time.process_time()
    verdict = judge(
        FLOAT32, 60.0, selection=Selection(frozenset(["merge"])), statistics=True
    )
    spent = time.process_time() - start
    assert {timed.step.title for timed in verdict.steps} == {"kernels", "lattices"}
    assert spent < 2.0
    recorder = Remembering("jacobian")
    verdict = judge(recorder, 600.0, statistics=False)
    titles = [timed.step.title for timed in verdict.steps]
    assert not {"cornell-box", "many-lights"} & set(titles)
    assert verdict.judged == {"jacobian"}


def test_what_an_object_offers():
    class Odd:
        """Methods, and what only looks like them."""

        shade = merge = staticmethod(len)
        jacobain = targets = staticmethod(len)
        spatail = 3
        _temporal = staticmethod(len)
        helper = staticmethod(len)

        @property
        def initial(self):
            raise RuntimeError("no device")

    found = offer_of(Odd(), CONTRACT)
    assert found.passes == {"shade", "merge", "initial"}
    assert found.near == (("jacobain", "jacobian"), ("targets", "target"))
    assert Offer.from_plain(json.loads(json.dumps(found.as_plain()))) == found
    assert offer_of(FLOAT32, CONTRACT).passes == set(CONTRACT)


def test_a_golden_folder_must_have_the_precision_of_the_backend(dark, tmp_path, capsys):
    keep = tmp_path / "kept"
    run(capsys, dark, "--case", "kernel-shade", "--keep", keep)
    with pytest.raises(UsageError, match="calculates in float64"):
        judge("float64", 60.0, against=keep)
