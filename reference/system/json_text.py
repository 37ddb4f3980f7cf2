"""Results as JSON that any program reads."""

import json
from collections.abc import Mapping
from math import isfinite
from pathlib import PurePath
from typing import Any


def json_text(results: Mapping[str, Any]) -> str:
    """Text of one object and a newline; numbers that are not finite become null.

    Raises TypeError: JSON has no form for a value.

    Parameters
    ----------
    results : mapping; of texts, numbers, arrays and paths, nested at will
    """
    return json.dumps(_plain(results), indent=2, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    """What JSON has a form for; numbers of NumPy are numbers."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):  # an array, or one number of NumPy
        return _plain(value.tolist())
    if isinstance(value, float):
        return float(value) if isfinite(value) else None
    if isinstance(value, PurePath):
        return str(value)
    if not isinstance(value, str | int | bool | None):
        raise TypeError(f"JSON has no form for {type(value).__name__}")
    return value
