"""The pages of Algorithms 3 and 4 name the lines of the paper where they belong."""

import ast
import inspect
import io
import re
import tokenize
from dataclasses import dataclass

import pytest

from restir_gi.reference.passes import spatial, temporal
from restir_gi.reference.resampling import reuse

PAGES = {
    "3": {"temporal_resampling": temporal},
    "4": {
        "spatial_resampling": spatial,
        "shifted": reuse,
        "could_have_made": reuse,
        "normalization": reuse,
    },
}
"""Functions that follow each listing, and the modules that they stand in."""


@dataclass(frozen=True)
class Line:
    """A line of a listing: what stands there, and the code that does it, by function.

    Each piece of code is a place where the line is named.
    """

    words: str
    code: dict[str, tuple[str, ...]]


def temporally(*code):
    return {"temporal_resampling": code}


def spatially(code, **details):
    return {
        "spatial_resampling": (code,),
        **{name: (detail,) for name, detail in details.items()},
    }


MERGED = "R_s = R_s.then(shifted(q, q_n), u_n)"
DIVIDED = "Z = normalization(mis, R_s, Q)"
SUMMED = "return one_over_z(R.M, could_have_made(R, Q))"
SEEN = "seen = q.sees("
SOUGHT = "for q_n, u_n in neighbors:"

LISTINGS = {
    "3": {
        1: Line("for each pixel", {}),
        2: Line("its new sample", temporally("S = initial.y")),
        3: Line("its temporal reservoir", temporally("R = begin(reused(q, past))")),
        4: Line("weight: target over density", temporally("initial_candidates(")),
        5: Line("the sample updates the reservoir", temporally("R = R.then(new, u)")),
        6: Line(
            "W: the sum over M and target", temporally("Z = norm", "finalize(R.kept")
        ),
        7: Line("the reservoir is stored", temporally("return cap_confidence(")),
    },
    "4": {
        1: Line("for each pixel", {}),
        2: Line("its spatial reservoir", spatially("R_s = begin(reused(q, past))")),
        3: Line("Q is the pixel alone", spatially("= [past, own]")),
        4: Line("a few times:", spatially(SOUGHT)),
        5: Line("a neighbour by chance", spatially(SOUGHT)),
        6: Line("how similar it is", spatially(SOUGHT)),
        7: Line("if not enough,", spatially(SOUGHT)),
        8: Line("the next", spatially(SOUGHT)),
        9: Line(
            "its temporal reservoir", spatially(MERGED, shifted="R_n = q_n.reservoirs")
        ),
        10: Line("the Jacobian", spatially(MERGED, shifted="J = q_n.jacobian()")),
        11: Line(
            "the target over the Jacobian",
            spatially(MERGED, shifted="reused_candidates(R_n, q.target(R_n.y), J)"),
        ),
        12: Line("if the sample is hidden,", spatially(MERGED, shifted=SEEN)),
        13: Line("the target is 0", spatially(MERGED, shifted=SEEN)),
        14: Line("the neighbour's reservoir is merged", spatially(MERGED)),
        15: Line("Q has the neighbour too", spatially("Q.append(q_n)")),
        16: Line("Z is 0", spatially(DIVIDED, normalization=SUMMED)),
        17: Line(
            "for each of Q:",
            spatially(DIVIDED, could_have_made="for slot, q_n in enumerate(Q):"),
        ),
        18: Line(
            "if its target is above 0,",
            spatially(DIVIDED, could_have_made="q_n.could_make(R.kept.y"),
        ),
        19: Line("its M counts in Z", spatially(DIVIDED, normalization=SUMMED)),
        20: Line("W: the sum over Z and target", spatially("finalize(R_s.kept, Z)")),
        21: Line("the reservoir is stored", spatially("return cap_confidence(")),
    },
}

NAMED = re.compile(r"\blines? (\d+)(?: (to|and) (\d+))?", re.IGNORECASE)


def numbers(text):
    """Lines that a text names, in its order."""
    found = []
    for first, how, last in NAMED.findall(text):
        a, b = int(first), int(last or first)
        found += range(a, b + 1) if how == "to" else sorted({a, b})
    return found


def tagged(source):
    """Comments of a source, each with its row and the code that it speaks of.

    That is the code beside it, or, where it has its rows for itself, below it.
    """
    rows = source.splitlines()
    comments = [
        (token.start[0] - 1, token.string)
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    ]
    for row, comment in comments:
        code = row
        while rows[code].strip().startswith("#"):
            code += 1
        yield row, comment, rows[code].split("  #")[0].strip()


def functions(source):
    """First and last row of each function of a source, and its docstring."""
    return {
        node.name: (node.lineno - 1, node.end_lineno, ast.get_docstring(node) or "")
        for node in ast.parse(source).body
        if isinstance(node, ast.FunctionDef)
    }


def faults(algorithm, sources):
    """What is wrong with the lines that sources name, by module."""
    listing = LISTINGS[algorithm]
    placed = {n: {} for n in listing}
    for name, module in PAGES[algorithm].items():
        source = sources[module]
        first, last, _ = functions(source)[name]
        order = []
        for row, comment, code in tagged(source):
            if first <= row < last:
                order += [(n, code) for n in numbers(comment)]
        if [n for n, _ in order] != sorted(n for n, _ in order):
            yield f"{name}: lines are out of order"
        for n, code in order:
            if n not in listing:
                yield f"{name}: Algorithm {algorithm} has no line {n}"
            else:
                placed[n].setdefault(name, []).append(code)
    for n, line in listing.items():
        if set(placed[n]) != set(line.code):
            yield f"line {n}, {line.words}: in {[*placed[n]]}, not {[*line.code]}"
        for name, code in line.code.items():
            found = placed[n].get(name, [])
            paired = zip(code, found, strict=False)
            if len(code) != len(found) or not all(a in b for a, b in paired):
                yield f"line {n}, {line.words}: {name} has {found}, not {code}"


SOURCES = {m: inspect.getsource(m) for m in (temporal, spatial, reuse)}


@pytest.mark.parametrize("algorithm", LISTINGS)
def test_each_line_of_the_listing_stands_where_it_is_done(algorithm):
    assert list(faults(algorithm, SOURCES)) == []


def test_the_listings_are_whole():
    assert [*LISTINGS["3"]] == [*range(1, 8)]
    assert [*LISTINGS["4"]] == [*range(1, 22)]


@pytest.mark.parametrize("algorithm", LISTINGS)
def test_docstrings_cite_the_listing(algorithm):
    """Line 1 has no code: pixels are rows.  Other lines that they name are there."""
    for name, module in PAGES[algorithm].items():
        _, _, text = functions(SOURCES[module])[name]
        assert f"Alg. {algorithm}" in text
        assert set(numbers(text)) <= set(LISTINGS[algorithm])
        page = name.endswith("_resampling")
        assert ("Line 1 is the loop over rows." in " ".join(text.split())) == page


def test_no_line_is_named_outside_of_the_pages():
    """In the modules of the pages; a comment elsewhere would escape the check."""
    for module, source in SOURCES.items():
        of = [functions(source)[n] for a in PAGES.values() for n in a if a[n] is module]
        for row, comment, _ in tagged(source):
            inside = any(first <= row < last for first, last, _ in of)
            assert inside or not numbers(comment)


WRONG = {
    "a line is left out": (spatial, "  # line 15", ""),
    "a line is invented": (spatial, "# lines 20 and 21", "# lines 20 to 22"),
    "a line is off by one": (reuse, "# line 10, Eq. 11", "# line 11, Eq. 11"),
    "two lines change places": (reuse, "# lines 12 and 13", "# lines 8 and 13"),
    "a line is named twice": (reuse, "  # line 18", "  # lines 17 and 18"),
    "code moves away from its line": (
        spatial,
        "    R_s = begin(reused(q, past))  # line 2\n"
        "    R_s = R_s.then(reused(q, own), u_own)\n",
        "    R_s = begin(reused(q, past))\n"
        "    R_s = R_s.then(reused(q, own), u_own)  # line 2\n",
    ),
    "a step is done elsewhere": (reuse, "# lines 16 and 19", "# line 19"),
}


@pytest.mark.parametrize("name", WRONG)
def test_control_a_wrong_line_is_told(name):
    module, old, new = WRONG[name]
    assert SOURCES[module].count(old) == 1
    sources = {**SOURCES, module: SOURCES[module].replace(old, new)}
    assert list(faults("4", sources)) != []


@pytest.mark.parametrize("n", range(2, 8))
def test_control_no_line_of_algorithm_3_may_be_missing(n):
    text = re.sub(rf"# line {n}\b", "#", SOURCES[temporal])
    text = re.sub(rf"# lines {n} and 7", "# line 7", text)
    text = re.sub(rf"# lines (\d) and {n}", r"# line \1", text)
    assert list(faults("3", {**SOURCES, temporal: text})) != []
