"""Arrays of whatever library, as arrays of NumPy in this machine's memory."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.system.errors import UsageError

READABLE = (1, 3, 11, 13)
"""Devices of DLPack whose memory the processor reads: its own, pinned and managed."""


def host_array(value: Any) -> NDArray[Any]:
    """An array of whatever library, in this machine's memory.

    Taken are arrays of NumPy; what says by ``__cuda_array_interface__`` or
    ``__dlpack_device__`` that it is on a device, and has a method ``get`` (CuPy) or
    ``cpu`` (PyTorch) that copies it; what has ``__dlpack__``; and buffers.

    Raises UsageError: it is none of these, or it cannot be copied.
    """
    kind = type(value).__name__
    # Whatever another library raises, it is the array that cannot be read.
    try:
        copied = _copied(value, kind) if _is_on_device(value) else value
        array = _taken(copied)
    except UsageError:
        raise
    except Exception as error:
        raise UsageError(
            f"a {kind} cannot be read as an array: {error}; give one with DLPack, with"
            " __cuda_array_interface__ and `get` or `cpu`, or a buffer"
        ) from error
    if array.dtype.kind not in "biufV" or array.dtype.hasobject:
        raise UsageError(f"a {kind} of {array.dtype} has no numbers; give an array")
    return array


def _is_on_device(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return False
    device = getattr(value, "__dlpack_device__", None)
    if device is not None:
        return device()[0] not in READABLE
    return hasattr(value, "__cuda_array_interface__")


def _copied(value: Any, kind: str) -> Any:
    """What an object on a device makes of itself on the host."""
    for method in ("get", "cpu"):
        copy = getattr(value, method, None)
        if callable(copy):
            return copy()
    raise UsageError(
        f"a {kind} is on a device, and has neither `get` nor `cpu` that copies it; copy"
        " it to the host, and give that"
    )


def answered_arrays(outputs: Any) -> dict[str, NDArray[Any]]:
    """What a pass of a backend returns, by name: arrays of any library, or lists.

    Raises UsageError: an array cannot be read or copied.
    """
    return {name: _answered(value) for name, value in dict(outputs).items()}


def _answered(value: Any) -> NDArray[Any]:
    foreign = hasattr(value, "__dlpack__") or _is_on_device(value)
    is_own = isinstance(value, np.ndarray)
    return host_array(value) if foreign and not is_own else np.asarray(value)


def _taken(value: Any) -> NDArray[Any]:
    if isinstance(value, np.ndarray):
        return value
    if hasattr(value, "__dlpack__"):
        return np.from_dlpack(value)
    return np.asarray(memoryview(value))
