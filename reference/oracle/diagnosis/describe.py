"""The known mistakes as a page of the documentation."""

from collections.abc import Iterable

from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis

INTRODUCTION = """\
# Known mistakes

<!-- Written by restir_gi.reference.oracle.diagnosis.describe; a test compares. -->

When a pass is wrong, it is replayed under each mistake of this page. One that
reproduces *every* answer that the backend gave for the pass, to rounding, is named;
if several do, all of them are, since the cases do not tell them apart; if none does,
sets of them are tried, and if none of those does, that is said. What brings no bias
is marked as a departure. "Seen" says where it has happened, as far as a paper, a
change or a discussion tells.
"""


def describe(hypotheses: Iterable[Hypothesis]) -> str:
    """Page of the known mistakes.

    Parameters
    ----------
    hypotheses : iterable of Hypothesis; in the order of the page
    """
    return INTRODUCTION + "".join(_paragraph(h) for h in hypotheses)


def _paragraph(h: Hypothesis) -> str:
    seen = f"\nSeen: {'; '.join(h.seen)}.\n" if h.seen else ""
    passes = ", ".join(f"`{name}`" for name in h.passes)
    return (
        f"\n({h.name})=\n## {h.name}\n\n{h.mistake[0].upper()}{h.mistake[1:]}.\n\n"
        f"{_kind(h)}- wrong: {h.wrong}\n- right: {h.right}\n"
        f"- shows in: {passes}{_where(h)}\n{seen}"
    )


def _where(h: Hypothesis) -> str:
    """With which values of a setting alone it shows."""
    if h.only is None:
        return ""
    setting, values = h.only
    return f", where `{setting}` is {' or '.join(values)}"


def _kind(h: Hypothesis) -> str:
    if h.declared:
        return f"- departure where it is declared: {h.declared}\n"
    return f"- departure: {h.departure}\n" if h.departure else ""
