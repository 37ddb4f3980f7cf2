"""The exercises of the lessons: wrong as they stand, right with their answers.

The pages themselves run when the documentation is built.
"""

import difflib
import importlib.util
import inspect
import re
from pathlib import Path

import pytest

LESSONS = Path(__file__).parents[2] / "docs" / "lessons"
STEPS = range(1, 9)


def exercise(step):
    path = LESSONS / "exercises" / f"exercise_{step}.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def answer(step):
    """The mended function: its name and its source."""
    page = (LESSONS / "answers.md").read_text("utf-8")
    fences = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(fences) == len(STEPS)
    source = fences[step - 1]
    return re.match(r"def (\w+)", source)[1], source


@pytest.mark.parametrize("step", STEPS)
def test_an_exercise_is_wrong_as_it_stands(step):
    with pytest.raises(AssertionError, match=r"instead of|share the key|wrong by"):
        exercise(step).check()


@pytest.mark.parametrize("step", STEPS)
def test_an_exercise_is_right_with_its_answer(step):
    module = exercise(step)
    name, source = answer(step)
    exec(source, vars(module))
    assert callable(getattr(module, name))
    module.check()


@pytest.mark.parametrize("step", STEPS)
def test_the_answer_mends_one_line(step):
    """Of the very function that the page shows; a line may also be put in."""
    name, source = answer(step)
    (page,) = LESSONS.glob(f"plot_{step}_*.py")
    assert f":pyobject: {name}\n" in page.read_text("utf-8")
    printed = inspect.getsource(getattr(exercise(step), name))
    lines = difflib.unified_diff(
        printed.strip().splitlines(), source.strip().splitlines(), n=0, lineterm=""
    )
    changed = [line[0] for line in list(lines)[3:] if line[:2] != "@@"]
    assert changed in (["-", "+"], ["+"])


@pytest.mark.parametrize("step", STEPS)
def test_a_lesson_shows_the_code_that_runs(step):
    """At least one function of the packages, by its name, not a copy."""
    (page,) = LESSONS.glob(f"plot_{step}_*.py")
    text = page.read_text("utf-8")
    shown = re.findall(r"literalinclude:: /\.\./(\S+)\n#? *:pyobject: (\w+)", text)
    assert shown
    for path, name in shown:
        source = (LESSONS.parents[1] / path).read_text("utf-8")
        assert re.search(rf"^(def|class) {name}\b", source, re.MULTILINE), (path, name)
