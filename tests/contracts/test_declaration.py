"""What a declaration says, and what is told of one that cannot be."""

import json
import re
import tomllib
from io import StringIO
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from rich.console import Console

from restir_gi.reference.cli import check_pictures
from restir_gi.reference.cli.main import main
from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.backends.selected import SelectedBackend, Selection
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.cases import Case, UnaskedError
from restir_gi.reference.oracle.checking import judge, told
from restir_gi.reference.oracle.contract.fields import Setting
from restir_gi.reference.oracle.declaration.choices import (
    EXCLUSIVE,
    KEYS,
    OF_ALL,
    OF_PASSES,
)
from restir_gi.reference.oracle.declaration.read import read_declaration, with_names
from restir_gi.reference.oracle.declaration.schema import PUBLISHED, declaration_schema
from restir_gi.reference.oracle.declaration.words import words_of
from restir_gi.reference.oracle.diagnosis.diagnose import known_mistakes
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import parts, whole_contract
from restir_gi.reference.oracle.prepared_frame import prepare_frame
from restir_gi.reference.oracle.pytest_plugin import Oracle
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.reports.verdict.plain import as_plain
from restir_gi.reference.reports.verdict.table import table
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.system.errors import UsageError

CONTRACT = whole_contract()
DOCS = Path(__file__).parents[2] / "docs"
FENCE = re.compile(r"^```toml\n(.*?)^```", re.MULTILINE | re.DOTALL)
BY_NAME = {key.name: key for key in KEYS}


def nested(name, value):
    """A choice, in the table that its name has before the dot."""
    table, _, inner = name.rpartition(".")
    return {table: {inner: value}} if table else {name: value}


def declared(choices=None, **more):
    """The declaration of some choices."""
    table = {"schema": "restir-declaration 1", "choices": choices or {}}
    return read_declaration(table | more)


def refusal(table):
    """What is told of a declaration."""
    with pytest.raises(UsageError) as found:
        read_declaration({"schema": "restir-declaration 1"} | table)
    text = str(found.value)
    assert "\n" not in text
    return text


def examples():
    """Declarations that the documentation shows, by page and place."""
    for path in sorted(DOCS.rglob("*.md")):
        blocks = FENCE.findall(path.read_text(encoding="utf-8"))
        for place, text in enumerate(blocks):
            if "restir-declaration" in text:
                yield pytest.param(text, id=f"{path.stem}-{place}")


@pytest.mark.parametrize("text", [*examples()])
def test_examples_of_the_documentation_are_right(text):
    table = tomllib.loads(text)
    Draft202012Validator(declaration_schema()).validate(table)
    assert read_declaration(table).says_anything


def test_the_schema_is_a_schema_and_is_published(capsys):
    Draft202012Validator.check_schema(declaration_schema())
    assert json.loads(PUBLISHED.read_text(encoding="utf-8")) == declaration_schema()
    assert main(["check", "--declaration-schema"]) == 0
    assert json.loads(capsys.readouterr().out) == declaration_schema()


# ------------------------------------------------------------ choices

SILENT = {"W_of_nulls", "generator", "pixel"}
"""Keys with a value that changes no rule."""

WRONG = {
    bool: "yes",
    str: "nonsense",
    int: -1,
    float: -1,
    list: [3],
}


@pytest.mark.parametrize("key", KEYS, ids=lambda key: key.name)
def test_a_key_that_is_right(key):
    said = declared(nested(key.name, key.example))
    none = declared(nested(key.name, key.contract)) if key.contract != 0 else declared()
    assert none.hypotheses == ()
    assert bool(said.hypotheses) == (key.name not in SILENT)
    for h in said.hypotheses:
        assert h.departure
        assert set(h.passes) <= set(CONTRACT)
        assert all((h.name, h.mistake, h.wrong, h.right))
        assert h.rules != CONTRACT_RULES or key.name == "boiling"


@pytest.mark.parametrize("key", KEYS, ids=lambda key: key.name)
def test_a_key_that_is_wrong(key):
    value = WRONG[type(key.example)]
    text = refusal({"choices": nested(key.name, value)})
    shown = json.dumps(value)
    right = "known are" if key.name == "names" else key.form["description"]
    if key.name == "names":
        text = refusal({"choices": nested(key.name, ["nonsense"])})
        shown = "'nonsense'"
    assert f"choices.{key.name}" in text
    assert shown in text
    assert right in text


@pytest.mark.parametrize(
    ("name", "value", "hypothesis", "field", "rule"),
    [
        (
            "jacobian.clamped",
            ["1/3", 3],
            "jacobian-clamped-to-3",
            "clamped",
            (1 / 3, 3),
        ),
        ("jacobian.clamped", [0, 8], "jacobian-at-most-8", "clamped", (0, 8)),
        (
            "jacobian.clamped",
            [0.2, 7],
            "jacobian-clamped-to-0.2-7",
            "clamped",
            (0.2, 7),
        ),
        (
            "jacobian.refused",
            [0.1, 10],
            "jacobian-rejected-beyond-10",
            "refused",
            (0.1, 10),
        ),
        (
            "jacobian.refused_both_ways",
            ["1/5", 5],
            "jacobian-refused-both-ways-at-5",
            "refused",
            (0.2, 5),
        ),
        (
            "jacobian.clamped",
            [0.5, inf],
            "jacobian-clamped-to-0.5-inf",
            "clamped",
            None,
        ),
        ("W_most", 10, "weight-cut-at-10", "W_most", 10),
        ("W_most", 12.5, "weight-cut-at-12.5", "W_most", 12.5),
        ("divisor_least", 0.001, "divisor-at-least-0.001", "divisor_least", 0.001),
        ("M.most", 1023, "confidence-at-most-1023", "most_confidence", 1023),
        ("order", "past-last", "past-last", "order", "past-last"),
        ("cap", "both", "capped-twice", "cap_arriving", "own"),
        ("cap", "both, past alone", "past-capped-twice", "cap_arriving", "past"),
        ("mis", "chained-1/Z", "chained-one-over-z", "normalization", "chained-1/Z"),
        ("mis", "own", "weights-of-its-own", "normalization", "own"),
        ("storage", "rgbe", "stored-as-rgbe", "storage", "rgbe"),
    ],
)
def test_names_and_rules(name, value, hypothesis, field, rule):
    said = declared(nested(name, value))
    assert [h.name for h in said.hypotheses] == [hypothesis]
    assert rule is None or getattr(said.rules, field) == rule


def test_a_floor_of_any_number_is_in_the_target():
    rules = declared({"target": {"least": 0.02, "luminance": "largest"}}).rules
    assert rules.target.least == 0.02
    assert rules.target.light.__name__ == "largest_channel"


def test_kinds_of_what_is_known_to_be_biased():
    kinds = {
        key.name: {
            h.departure for h in declared(nested(key.name, key.example)).hypotheses
        }
        for key in KEYS
    }
    biased = {name for name, of in kinds.items() if "bias" in of}
    assert biased == {
        "visibility_in_domain",
        "jacobian.refused",
        "jacobian.clamped",
        "jacobian.omitted",
        "W_most",
        "divisor_least",
        "boiling",
        "max_age",
    }
    assert [h.departure for h in declared({"mis": "1/M"}).hypotheses] == ["bias"]


def test_a_pass_may_have_choices_of_its_own():
    said = declared(
        {"order": "own-first", "spatial": {"order": "contract", "mis": "balance"}}
    )
    assert {h.name: h.passes for h in said.hypotheses} == {
        "own-first": ("temporal", "moved", "fused"),
        "balance": ("spatial",),
    }
    assert said.rules_of("spatial").order == "contract"
    said = declared({"cap": "never", "spatial": {"cap": "both"}})
    assert said.rules_of("moved").cap_when == "never"
    with pytest.raises(UsageError, match="spatial makes other choices"):
        said.rules  # noqa: B018


def test_keys_of_all_passes_are_not_of_one():
    for name in OF_ALL:
        text = refusal({"choices": {"spatial": {name: BY_NAME[name].example}}})
        assert f"choices.spatial.{name} is no key" in text


@pytest.mark.parametrize(("one", "other", "right"), EXCLUSIVE)
def test_what_cannot_hold_together_is_told(one, other, right):
    whole = nested(one, BY_NAME[one].example)
    for name, value in nested(other, BY_NAME[other].example).items():
        whole[name] = {**whole.get(name, {}), **value}
    assert f"choices.{one} beside {other}: {right}" in refusal({"choices": whole})


def test_unknown_weights_hide_no_bias():
    text = refusal({"choices": {"mis": "own", "W_most": 10}})
    assert "mis is own, beside weight-cut-at-10" in text


@pytest.mark.parametrize("limits", [[3, 1], [2, 2]])
def test_limits_are_in_order(limits):
    text = refusal({"choices": {"jacobian": {"refused": limits}}})
    assert f"refused is {limits}, and should be the least and then the most" in text


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"choices": {"W_most": nan}}, "choices.W_most is nan"),
        ({"choices": {"jacobian": {"clamped": ["1/0", 3]}}}, '["1/0", 3], and should'),
        ({"choises": {}}, "choises is no key, did you mean choices?"),
        ({"schema": "restir-declaration 2"}, 'should be "restir-declaration 1"'),
        ({"schema": 1}, "schema is 1, and should be"),
        ({"choices": []}, "choices is [], and should be a table of choices"),
        ({"accept": "x"}, 'accept is "x", and should be a list of names'),
    ],
)
def test_other_forms_are_told(table, words):
    assert words in refusal(table)


def test_the_form_has_to_be_said():
    with pytest.raises(UsageError, match="schema is missing, and should be"):
        read_declaration({})


def test_everything_is_told_at_once():
    text = refusal(
        {
            "has": {"neighbors": [0], "history": 1},
            "choices": {"cap": "late", "jacobian": {"clampd": [1, 2]}},
        }
    )
    for words in ("has.neighbors", "has.history", "choices.cap", "mean clamped?"):
        assert words in text


# ------------------------------------------------------------ accept, and names


def test_what_is_accepted_has_to_be_declared():
    choices = {"jacobian": {"clamped": ["1/3", 3]}}
    said = declared(choices, accept=["jacobian-clamped"])
    assert said.accepts("jacobian-clamped-to-3")
    assert not said.accepts("jacobian-clamp")
    text = refusal({"choices": choices, "accept": ["jacobian-clampd-to-3"]})
    assert "unknown declared choice" in text
    assert "did you mean jacobian-clamped-to-3?" in text


def test_names_of_the_catalogue_are_choices():
    said = with_names(declared({"cap": "never"}), ["own-first", "one-over-m"], ())
    kinds = {h.name: h.departure for h in said.hypotheses}
    expected = {"never-capped": "confidence", "own-first": "order"}
    assert kinds == expected | {"one-over-m": "bias"}
    with pytest.raises(UsageError, match=r"'own-frist'; did you mean own-first\?"):
        with_names(said, ["own-frist"], ())
    with pytest.raises(UsageError, match="cannot hold together"):
        with_names(said, ["capped-on-arrival"], ())


def test_every_name_of_the_catalogue_may_be_declared():
    for h in known_mistakes():
        (one,) = declared({"names": [h.name]}).hypotheses
        assert one.departure == (h.departure or h.declared or "bias")
        assert one.passes


# ------------------------------------------------------------ what it has


def test_what_is_not_had_is_declined():
    said = declared(has={"target": ["outgoing"], "spatial": {"mis": ["1/Z"]}})
    declined = said.selection.declined
    assert ("spatial", "mis", "1/M") in declined
    assert ("moved", "mis", "1/M") not in declined
    assert {p for p, name, _ in declined if name == "target"} == {
        p.name for p in CONTRACT.values() if any(s.name == "target" for s in p.settings)
    } - {"gbuffer", "reproject"}


def test_a_pass_before_a_setting_comes_first():
    said = declared(has={"mis": ["1/Z"], "moved": {"mis": ["1/M", "1/Z"]}})
    assert ("spatial", "mis", "1/M") in said.selection.declined
    declined = {word for p, _, word in said.selection.declined if p == "moved"}
    assert not declined & {"1/M", "1/Z"}


def test_passes_neighbors_history_and_generator():
    has = {"passes": ["spatial", "shade"], "neighbors": [1, 3], "history": False}
    said = declared({"generator": "own"}, has=has)
    assert said.has == has
    assert said.generator == "own"
    assert said.selection.only == {"spatial", "shade"}
    assert said.selection.skip == {"random"}
    assert said.selection.neighbors == {1, 3}
    assert not said.selection.history
    assert [h.name for h in said.hypotheses] == ["history-not-merged"]


def test_one_over_m_alone_is_biased_by_design():
    (one,) = declared(has={"mis": ["1/M"]}).hypotheses
    assert (one.name, one.passes) == ("one-over-m", ("moved", "spatial", "fused"))
    assert one.departure == "bias"
    assert declared(has={"mis": ["1/M", "1/Z"]}).hypotheses == ()
    (one,) = declared({"mis": "balance"}, has={"spatial": {"mis": ["1/M"]}}).hypotheses
    assert one.name == "balance"


@pytest.mark.parametrize(
    ("has", "words"),
    [
        ({"passes": ["spatal"]}, "has.passes: unknown pass 'spatal'; did you mean"),
        ({"passes": []}, "has.passes is [], and should be a list of passes"),
        ({"target": "outgoing"}, 'has.target is "outgoing", and should be a list'),
        ({"target": ["outgoin"]}, "has.target: unknown value 'outgoin'; did you mean"),
        ({"tagret": ["outgoing"]}, "has.tagret: unknown key, and no setting 'tagret'"),
        ({"spatial": {"mi": ["1/Z"]}}, "has.spatial.mi: unknown setting of spatial"),
        ({"spatial": {"cap": ["3"]}}, "has.spatial.cap: unknown setting of spatial"),
        ({"spatail": {"mis": ["1/Z"]}}, "has.spatail: unknown pass 'spatail'"),
        ({"neighbors": [31]}, "has.neighbors is [31], and should be a list of how"),
        ({"neighbors": [1.5]}, "has.neighbors is [1.5]"),
        ({"history": "no"}, 'has.history is "no", and should be true or false'),
    ],
)
def test_what_cannot_be_had_is_told(has, words):
    assert words in refusal({"has": has})


def test_words_of_settings_are_those_of_the_cases():
    """Settings of all cases that are words, but for names of scenes."""
    at = prepare_frame(find_scene("cornell-box"), 16, 1)
    cases = [*frame_cases(at, "float32"), *(p.case for p in row_probes("float32"))]
    cases += [q.case for part in parts() for q in part.probes("float32", 1)]
    seen = set()
    for case in cases:
        settings = {s.name: s for s in CONTRACT[case.pass_name].settings}
        for name, value in case.settings.items():
            if isinstance(value, str) and settings[name].values != "name":
                assert value in words_of(settings[name]), (case.name, name)
                seen.add(name)
    assert {"target", "mis"} <= seen


def test_declared_settings_are_asked_where_they_are_had():
    one = CONTRACT["shade"]
    layout = Setting("layout", "struct", "of rows", ("packed",), "struct")
    passes = {"shade": type(one)(**{**fields_of(one), "settings": (layout,)})}
    plain, packed = (
        {} if word is None else {"layout": word} for word in (None, "packed")
    )
    W = {"W": np.zeros(1, "f4")}

    def asked(selection):
        cases = [Case("a", "shade", s, W) for s in (plain, packed)]
        return [
            selection.has_declared(passes, c) and selection.has_settings(passes, c)
            for c in cases
        ]

    assert asked(Selection()) == [True, False]
    packed_alone = frozenset({("shade", "layout", "struct")})
    more = frozenset({("shade", "layout", "packed")})
    assert asked(Selection(more=more)) == [True, True]
    assert asked(Selection(more=more, declined=packed_alone)) == [False, True]


def fields_of(one):
    return {name: getattr(one, name) for name in type(one).__slots__}


def test_cases_with_other_numbers_of_neighbors_are_not_asked():
    calls = []

    class Counting:
        """Pass spatial, which tells how many neighbours it was given."""

        @staticmethod
        def spatial(neighbors, **rest):
            calls.append(neighbors.shape[1])
            return FLOAT32.spatial(neighbors=neighbors, **rest)

    cases = [p.case for p in row_probes("float32") if p.case.pass_name == "spatial"]
    counts = {case.inputs["neighbors"].shape[1] for case in cases}
    assert counts == {3, 30}
    said = declared(has={"neighbors": [3]})
    SelectedBackend(InsideBackend(Counting()), said.selection).run(CONTRACT, cases)
    assert set(calls) == {3}


# ------------------------------------------------------------ in a check


class Scattered:
    """One target and one MIS weight; the others are not implemented."""

    asked = ()

    def target(self, target, **given):
        """Equation 9 alone."""
        type(self).asked += (target,)
        if target != "scattered":
            raise NotImplementedError(target)
        return FLOAT32.target(target=target, **given)


def test_what_is_not_implemented_is_not_had():
    verdict = judge(Scattered(), 60.0, statistics=False)
    assert verdict.status == "PASS", told(verdict)
    assert "outgoing" in Scattered.asked
    unanswered = [a for t in verdict.steps for a in t.step.answers if a.finding is None]
    settings = {a.probe.case.settings.get("target") for a in unanswered}
    assert "outgoing" in settings


SOURCE = """
from restir_gi.reference.oracle.builtin.backend import FLOAT32

class Mine:
    declaration = {DECLARATION!r}

    def target(self, target, **given):
        if target != "scattered":
            raise NotImplementedError(target)
        return dict(p_hat=2 * FLOAT32.target(target=target, **given)["p_hat"])

BACKEND = Mine()
"""


def test_what_is_not_implemented_is_not_had_in_another_process(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(SOURCE.format(DECLARATION=None), encoding="utf-8")
    verdict = judge(str(path), 60.0, statistics=False)
    assert verdict.status == "PASS", told(verdict)
    assert verdict.followed == []


def test_an_object_brings_its_declaration_along(tmp_path):
    said = {"schema": "restir-declaration 1", "choices": {"target": {"scale": 2}}}
    path = tmp_path / "mine.py"
    path.write_text(SOURCE.format(DECLARATION=said), encoding="utf-8")
    (one,) = judge(str(path), 60.0, statistics=False).followed
    assert one.text == "target follows target-doubled-whatever-is-asked"
    toml = tmp_path / "mine.toml"
    toml.write_text('schema = "restir-declaration 1"\nchoices.target.scale = 2.0\n')
    path.write_text(SOURCE.format(DECLARATION=str(toml)), encoding="utf-8")
    assert judge(str(path), 60.0, statistics=False).followed == [one]


def test_a_declaration_of_the_check_comes_before_that_of_the_object():
    class Misdeclared:
        """Its own declaration is wrong."""

        declaration = {"schema": "none"}  # noqa: RUF012
        finalize = staticmethod(FLOAT32.finalize)

    with pytest.raises(UsageError, match="should be"):
        judge(Misdeclared(), 60.0)
    with pytest.raises(UsageError, match="declaration is int, and should be a mapping"):
        judge(type("Other", (Misdeclared,), {"declaration": 3})(), 60.0)
    said = {"schema": "restir-declaration 1", "has": {"passes": ["finalize"]}}
    assert (
        judge(Misdeclared(), 60.0, statistics=False, declaration=said).status == "PASS"
    )


def test_passes_that_are_not_had_are_not_absent():
    said = {"schema": "restir-declaration 1", "has": {"passes": ["shade"]}}
    verdict = judge(FLOAT32, 60.0, statistics=False, declaration=said)
    assert verdict.judged == {"shade"}
    assert verdict.absent == []
    with pytest.raises(UsageError, match="merge is required and left out"):
        judge(FLOAT32, 60.0, declaration=said, require=("merge",))
    only = Selection(only=frozenset({"merge"}))
    with pytest.raises(UsageError, match="merge is to be asked"):
        judge(FLOAT32, 60.0, declaration=said, selection=only)


class Cut:
    """W is cut at 2.5."""

    @staticmethod
    def finalize(**given):
        """W of a reservoir."""
        return {"W": FLOAT32.finalize(**given)["W"].clip(max=np.float32(2.5))}


CUT = {"schema": "restir-declaration 1", "choices": {"W_most": 2.5}}


def test_a_bias_by_design_fails_until_it_is_accepted(restir_oracle):
    with pytest.raises(pytest.fail.Exception, match="biased by design") as found:
        Oracle().check(Cut(), budget=60.0, declaration=CUT)
    assert "--accept weight-cut-at-2.5" in str(found.value)
    verdict = restir_oracle.check(Cut(), declaration=CUT, accept=["weight-cut"])
    (one,) = verdict.biases
    assert one.text == "finalize is biased by design in weight-cut-at-2.5"


def test_without_a_declaration_it_is_a_mistake():
    verdict = judge(Cut(), 60.0, statistics=False)
    assert verdict.status == "FAIL"
    assert verdict.wrong
    assert verdict.diagnoses[0].explanations == ()


def test_the_command_line_says_it(tmp_path, capsys):
    path, toml = tmp_path / "cut.py", tmp_path / "cut.toml"
    path.write_text(
        "from restir_gi.reference.oracle.builtin.backend import FLOAT32\n"
        "class Mine:\n"
        "    def finalize(self, **given):\n"
        "        return {'W': FLOAT32.finalize(**given)['W'].clip(max=2.5)}\n"
        "BACKEND = Mine()\n"
    )
    toml.write_text('schema = "restir-declaration 1"\nchoices.W_most = 2.5\n')
    about = ["check", str(path), "--declaration", str(toml), "--json"]
    assert main(about) == 1
    plain = json.loads(capsys.readouterr().out)
    assert plain["headline"].startswith("biased by design in weight-cut-at-2.5")
    assert "accept it by accept = [" in plain["headline"]
    said = plain["declaration"]
    assert said["choices"]["weight-cut-at-2.5"][0] == "finalize"
    assert said["followed"][0]["state"] == "followed"
    assert said["biases"] == [
        {
            "pass": "finalize",
            "choices": ["weight-cut-at-2.5"],
            "accepted": False,
            "light": None,
            "told": "finalize is biased by design in weight-cut-at-2.5",
        }
    ]
    assert main([*about, "--accept", "weight-cut", "--out", str(tmp_path / "r")]) == 0
    plain = json.loads(capsys.readouterr().out)
    status = {p["name"]: p["status"] for p in plain["passes"]}
    assert status["finalize"] == "by design"
    page = (tmp_path / "r" / "index.html").read_text(encoding="utf-8")
    assert "finalize follows weight-cut-at-2.5" in page
    assert "Biased by design: finalize" in page


def test_the_terminal_says_it():
    verdict = judge(Cut(), 60.0, statistics=False, declaration=CUT)
    console = Console(file=StringIO(), width=200)
    console.print(table(as_plain(verdict, "mine", CONTRACT)))
    shown = console.file.getvalue()
    assert "declared: finalize follows weight-cut-at-2.5" in shown
    assert "in weight-cut-at-2.5; not accepted" in shown


def test_a_file_that_cannot_be_read_is_told(tmp_path, capsys):
    for text, words in (("schema =", "is not TOML"), (None, "cannot read")):
        path = tmp_path / "mine.toml"
        path.unlink(missing_ok=True)
        if text is not None:
            path.write_text(text)
        assert main(["check", "float32", "--declaration", str(path)]) == 2
        assert words in capsys.readouterr().err


def test_of_pictures_it_says_where_rays_begin(tmp_path, capsys, monkeypatch):
    asked = []

    def judged(pictures, truths, convention, *rest, **more):
        asked.append(convention.pixel)
        raise UnaskedError

    monkeypatch.setattr(check_pictures, "judge_pictures", judged)
    path = tmp_path / "mine.toml"
    path.write_text('schema = "restir-declaration 1"\nchoices.pixel = "box"\n')
    about = ["check", "true {seed} {out}", "--declaration", str(path)]
    assert main(about) == 3
    assert main([*about, "--pixel", "box"]) == 3
    assert main(about[:2]) == 3
    assert asked == ["box", "box", "center"]
    capsys.readouterr()
    assert main([*about, "--pixel", "center"]) == 2
    assert "--pixel is center, and" in capsys.readouterr().err
    path.write_text('schema = "restir-declaration 1"\nchoices.cap = "never"\n')
    assert main(about) == 3
    assert "says pixel, and nothing else" in capsys.readouterr().err


def test_names_after_declare_have_to_be_known(capsys):
    assert main(["check", "float32", "--declare", "own-frist"]) == 2
    assert "did you mean own-first?" in capsys.readouterr().err


def test_every_pass_with_choices_of_its_own_is_a_pass():
    assert set(OF_PASSES) <= set(CONTRACT)


@pytest.mark.parametrize("ages", [[30, 15], [15, 15]])
def test_ages_in_the_wrong_order_are_refused(ages):
    assert "max_age is" in refusal({"choices": {"max_age": ages}})
