"""Cases as files: raw little-endian buffers, and an index that ``fscanf`` reads.

A folder of cases holds ``cases.txt``, a line a thing, words apart by one space::

    restir-cases 1
    precision float32
    case temporal-cornell-box temporal 4096
    set cap 30
    in u float32 1 4096 temporal-cornell-box/in/u.raw
    out W float32 1 4096 temporal-cornell-box/out/W.raw
    may term_Z float32 1 4096 temporal-cornell-box/out/term_Z.raw
    end

``may`` is what a report shows where a backend writes it.  After these words stand the
name, the type (float32, float64, int32, uint32), the
number of dimensions, each dimension, and the file, relative to the folder.  Files hold
nothing but the numbers, in C order.  Folders of outputs exist already.
"""

import os
from collections.abc import Iterable
from io import BytesIO
from pathlib import Path
from typing import Any, get_args
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.cases import (
    Case,
    Failure,
    Outcome,
    output_shapes,
    pass_of,
)
from restir_gi.reference.oracle.contract.fields import (
    Passes,
    Precision,
    Value,
    dtype_of,
)
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import make_folder, read_file

INDEX, FORM = "cases.txt", "restir-cases 1"

MOST_TIMES, MOST_MORE = 4, 2**16
"""Bytes that a backend's file may have: so many times what the contract promises, and
more for what stands around the numbers."""


def write_cases(
    folder: Path, passes: Passes, precision: Precision, cases: Iterable[Case]
) -> None:
    """Write what a backend needs.

    Raises UsageError: it cannot be written.

    Parameters
    ----------
    folder : Path; made if it does not exist
    """
    lines = [FORM, f"precision {precision}"]
    for case in cases:
        lines.append(f"case {case.name} {case.pass_name} {case.rows}")
        lines += [f"set {name} {value}" for name, value in case.settings.items()]
        make_folder(folder / case.name / "in")
        make_folder(folder / case.name / "out")
        for name, array in case.inputs.items():
            path = f"{case.name}/in/{name}.raw"
            _write(folder / path, np.ascontiguousarray(array).tobytes())
            lines.append(_line("in", name, array.dtype, array.shape, path))
        asked = pass_of(passes, case)
        words = dict.fromkeys(asked.outputs, "out") | dict.fromkeys(asked.terms, "may")
        for field, word in words.items():
            shape = output_shapes(passes, case)[field.name]
            path = f"{case.name}/out/{field.name}.raw"
            dtype = dtype_of(field.kind, precision)
            lines.append(_line(word, field.name, dtype, shape, path))
        lines.append("end")
    _write(folder / INDEX, ("\n".join(lines) + "\n").encode())


def read_cases(folder: Path) -> tuple[Precision, list[Case]]:
    """Read what `write_cases` wrote.

    Raises UsageError: no index, or one that cannot be read, or a file of another size
    than it says.

    Returns
    -------
    precision : 'float32' or 'float64'; of the backend
    cases : list of Case; in the order of the index
    """
    words = [line.split(" ") for line in _text(folder / INDEX).splitlines()]
    try:
        if " ".join(words[0]) != FORM or words[1][0] != "precision":
            raise ValueError
        precision: Any = words[1][1]
        if precision not in get_args(Precision):
            raise ValueError
        return precision, list(_cases(folder, words[2:]))
    except (ValueError, IndexError, TypeError) as error:  # also of a type or a shape
        raise UsageError(
            f"{folder / INDEX} is not an index of cases; it begins with {FORM!r}"
        ) from error


def read_outputs(
    folder: Path, passes: Passes, precision: Precision, case: Case
) -> Outcome:
    """Read what a backend wrote for a case: ``out/*.raw``, or ``out.npz``.

    Returns Buffers, Failure or None; ``None`` where it wrote nothing.
    """
    for packed in (folder / case.name / "out.npz", folder / case.name / "out/out.npz"):
        if os.path.lexists(packed):
            return _unpack(packed, passes, precision, case)
    found: dict[str, NDArray[Any]] = {}
    asked = pass_of(passes, case)
    for field in (*asked.outputs, *asked.terms):
        path = folder / case.name / "out" / f"{field.name}.raw"
        if not os.path.lexists(path):
            continue
        dtype = dtype_of(field.kind, precision)
        shape = output_shapes(passes, case)[field.name]
        wanted = int(np.prod(shape)) * dtype.itemsize
        try:
            contents = read_file(path, MOST_TIMES * wanted + MOST_MORE)
        except UsageError as error:
            return Failure(f"{case.name}: {error}")
        if len(contents) != wanted:
            state = "truncated" if len(contents) < wanted else "too long"
            return Failure(
                f"{case.name}: {field.name}.raw is {state}: {len(contents)} bytes"
                f" instead of {wanted}"
            )
        found[field.name] = np.frombuffer(contents, dtype).reshape(shape)
    return found or None


def outputs_size(passes: Passes, precision: Precision, case: Case) -> int:
    """Bytes of the outputs and terms that a case asks for."""
    asked, shapes = pass_of(passes, case), output_shapes(passes, case)
    return sum(
        int(np.prod(shapes[field.name])) * dtype_of(field.kind, precision).itemsize
        for field in (*asked.outputs, *asked.terms)
    )


def _write(path: Path, contents: bytes) -> None:
    # Not in one step, as pictures are: whoever wants that renames the whole folder.
    try:
        path.write_bytes(contents)
    except OSError as error:
        raise UsageError(
            f"cannot write {path}: {error.strerror}; name a folder with room"
        ) from error


def _line(
    word: str, name: str, dtype: np.dtype[Any], shape: tuple[int, ...], path: str
) -> str:
    sizes = " ".join(str(size) for size in (len(shape), *shape))
    return f"{word} {name} {dtype.name} {sizes} {path}"


def _cases(folder: Path, lines: list[list[str]]) -> Iterable[Case]:
    settings: dict[str, Value] = {}
    inputs: dict[str, NDArray[Any]] = {}
    for word, *rest in lines:
        if word == "case":
            name, pass_name, settings, inputs = rest[0], rest[1], {}, {}
        elif word == "set":
            settings[rest[0]] = _value(rest[1])
        elif word == "in":
            inputs[rest[0]] = _array(folder, rest)
        elif word == "end":
            yield Case(name, pass_name, settings, inputs)


def _array(folder: Path, words: list[str]) -> NDArray[Any]:
    shape = tuple(int(size) for size in words[3:-1])
    dtype = np.dtype(words[1]).newbyteorder("<")
    return np.frombuffer(read_file(folder / words[-1]), dtype).reshape(shape)


def _value(text: str) -> Value:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _unpack(path: Path, passes: Passes, precision: Precision, case: Case) -> Outcome:
    """Outputs of an NPZ, of which no more is read than was asked for."""
    most = MOST_TIMES * outputs_size(passes, precision, case) + MOST_MORE
    asked = pass_of(passes, case)
    found: dict[str, NDArray[Any]] = {}
    try:
        with ZipFile(BytesIO(read_file(path, most))) as file:
            names = set(file.namelist())
            for field in (*asked.outputs, *asked.terms):
                member = f"{field.name}.npy"
                if member not in names:
                    continue
                size = file.getinfo(member).file_size
                if size > most:
                    raise ValueError(
                        f"{field.name} has {size:,} bytes where {most:,} are too many"
                    )
                array = np.load(BytesIO(file.read(member)), allow_pickle=False)
                found[field.name] = np.asarray(array)
    # Damage shows as whatever the reader trips over first.
    except Exception as error:
        words = str(error) or type(error).__name__
        return Failure(f"{case.name}: out.npz cannot be read: {words}")
    return found


def _text(path: Path) -> str:
    try:
        return read_file(path).decode()
    except UnicodeDecodeError as error:
        raise UsageError(f"{path} is not text; it should be an index of cases") from (
            error
        )
