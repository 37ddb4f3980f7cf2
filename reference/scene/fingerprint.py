"""A short text that tells two scenes apart, whatever they are made of."""

from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import Any

import numpy as np


def fingerprint(value: Any) -> str:
    """Digest of a value: equal values, equal digest, in any process.

    Raises TypeError: something else is in it, whose value would be a matter of opinion.

    Parameters
    ----------
    value : dataclass, array, tuple, list, str, number or None
        Nested at will.  Arrays count by type, shape and bits, floats by their bits.

    Returns
    -------
    str; 64 hexadecimal digits
    """
    digest = sha256()
    _feed(digest, value)
    return digest.hexdigest()


def _feed(digest: Any, value: Any) -> None:
    # Each part says what it is and how long, so that no two values read alike.
    if isinstance(value, np.ndarray):
        digest.update(f"array {value.dtype.str} {value.shape};".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif is_dataclass(value) and not isinstance(value, type):
        digest.update(f"record {type(value).__name__} {len(fields(value))};".encode())
        for field in fields(value):
            _feed(digest, field.name)
            _feed(digest, getattr(value, field.name))
    elif isinstance(value, tuple | list):
        digest.update(f"list {len(value)};".encode())
        for item in value:
            _feed(digest, item)
    elif isinstance(value, np.generic):
        _feed(digest, value.item())
    elif isinstance(value, float):
        digest.update(f"float {value.hex()};".encode())
    elif value is None or isinstance(value, bool | int):
        digest.update(f"{type(value).__name__} {value};".encode())
    elif isinstance(value, str):
        text = value.encode(errors="backslashreplace")
        digest.update(f"text {len(text)};".encode() + text)
    else:
        raise TypeError(f"no fingerprint of {type(value).__name__}")
