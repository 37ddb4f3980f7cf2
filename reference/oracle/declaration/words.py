"""Words that a setting of the contract may be."""

import re

from restir_gi.reference.oracle.contract.fields import Setting

_NO_WORDS = re.compile(r"number|pixels|degrees|whole number|name$|m$|0 or 1")


def words_of(setting: Setting) -> tuple[str, ...]:
    """Words that a setting may be, those that have to be declared last.

    None of one that is a number, or a name of no list.

    Examples
    --------
    >>> words_of(Setting("mis", "1/M | 1/Z", "weight"))
    ('1/M', '1/Z')
    >>> words_of(Setting("cap", "number, at least 1", "limit of M"))
    ()
    """
    if _NO_WORDS.match(setting.values):
        return ()
    found = re.split(r" \| |, | or ", setting.values)
    return tuple(dict.fromkeys((*found, *setting.more)))
