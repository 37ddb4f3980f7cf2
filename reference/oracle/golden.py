"""Golden folders: inputs and expected outputs, for backends that are not here.

Beside the index and the raw buffers of :mod:`reference.oracle.raw` a folder holds
``manifest.json``, and for each case ``in.npz``, ``expected.npz``, ``expected/*.raw``
and, where its rows are the pixels of an image, ``frame.exr`` with a part for each
buffer.  A backend writes ``out/*.raw``, or ``out.npz``, or ``out/out.exr``.
"""

import json
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.errors import UsageError
from reference.exactness.registry import limits_of
from reference.files import make_folder, read_file
from reference.oracle.buffers import given
from reference.oracle.builtin.backend import BuiltIn
from reference.oracle.cases import Case
from reference.oracle.contract.fields import Passes, Precision
from reference.oracle.exr_frames import write_frames
from reference.oracle.parts import parts
from reference.oracle.raw import read_cases, write_cases
from reference.oracle.rungs.exact import exact_outputs, examined_exactly
from reference.oracle.rungs.kernels import kernel_probes
from reference.oracle.rungs.lattice import lattice_probes
from reference.oracle.rungs.probe import Probe
from reference.oracle.rungs.replayed import replayed
from reference.version import project_version

MANIFEST, FORM = "manifest.json", "restir-golden 1"


def expected(
    case: Case, precision: Precision, exactly: bool = False
) -> dict[str, NDArray[Any]]:
    """What a case should give: in double precision, rounded once.

    Parameters
    ----------
    case : Case
        With inputs of any precision.
    precision : 'float32' or 'float64'
        Of the result.
    exactly : bool
        Of a kernel whose case is held against exact numbers.

    Returns
    -------
    dict of str to array
        Of the built-in passes, and of kernels in 50 digits; at most the largest number
        of the precision.
    """
    wide = given(case.inputs, "float64")
    outputs = getattr(BuiltIn("float64"), case.pass_name)(**wide, **case.settings)
    if exactly:
        known = exact_outputs(case)
        outputs = {
            name: known.get(name, array).astype(array.dtype)
            for name, array in outputs.items()
        }
    most = float(np.finfo(precision).max)
    finite = {
        name: np.clip(array, -most, most) if array.dtype.kind == "f" else array
        for name, array in outputs.items()
    }
    return given(finite, precision)


def write_golden(
    folder: Path,
    passes: Passes,
    precision: Precision,
    probes: list[Probe],
    about: dict[str, Any],
    tell: Callable[[int, int, str], None],
) -> None:
    """Write a golden folder, whole or not at all.

    Parameters
    ----------
    folder : Path
        Does not exist, or is empty, or is a golden folder, which is replaced.
    passes : mapping of str to Pass
        The contract.
    precision : 'float32' or 'float64'
        Of the inputs.
    probes : list of Probe
        What is asked.
    about : dict
        What the manifest says of scene, size and seed.
    tell : callable
        Told how many cases are done, of how many.

    Raises
    ------
    UsageError
        The folder holds something else, or cannot be written.
    """
    _refuse_what_is_not_golden(folder)
    make_folder(folder.parent)
    try:
        new = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    except OSError as error:
        raise UsageError(
            f"--out {folder}: cannot write beside it: {error.strerror}"
        ) from error
    try:
        cases = [probe.case for probe in probes]
        write_cases(new, passes, precision, cases)
        for number, probe in enumerate(probes):
            _write_case(new / probe.case.name, precision, probe)
            tell(number + 1, len(probes), "cases")
        entries = [
            {
                "name": p.case.name,
                "pass": p.case.pass_name,
                "rung": p.rung,
                "rows": p.case.rows,
                "random": p.case.random,
                "width": p.case.width,
            }
            for p in probes
        ]
        manifest = {
            "form": FORM,
            "version": project_version(),
            "precision": precision,
            **about,
            "limits": {name: limits_of(name) for name in passes if limits_of(name)},
            "cases": entries,
        }
        (new / MANIFEST).write_text(json.dumps(manifest, indent=1), encoding="utf-8")
        new.chmod(0o755)
        if folder.exists():
            shutil.rmtree(folder)
        os.replace(new, folder)
    except OSError as error:
        raise UsageError(f"cannot write {folder}: {error.strerror}") from error
    finally:
        shutil.rmtree(new, ignore_errors=True)


def read_golden(folder: Path) -> tuple[Precision, list[Probe]]:
    """Questions of a golden folder.

    Parameters
    ----------
    folder : Path
        As `write_golden` left it.

    Returns
    -------
    precision : 'float32' or 'float64'
        Of the inputs.
    probes : list of Probe
        With the inputs as they stand in the files.

    Raises
    ------
    UsageError
        It is none.
    """
    try:
        manifest = json.loads(read_file(folder / MANIFEST))
        entries = {entry["name"]: entry for entry in manifest["cases"]}
        if manifest["form"] != FORM:
            raise ValueError
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(
            f"{folder / MANIFEST} is not the manifest of a golden folder; make one by"
            " restir golden"
        ) from error
    precision, cases = read_cases(folder)
    known = {
        probe.case.name: probe
        for probe in (
            *kernel_probes(precision),
            *lattice_probes(precision),
            *(probe for part in parts() for probe in part.probes(precision)),
        )
    }
    probes = []
    for case in cases:
        entry = entries.get(case.name)
        if entry is None:
            raise UsageError(f"{folder / MANIFEST} does not list the case {case.name}")
        full = Case(
            case.name,
            case.pass_name,
            case.settings,
            case.inputs,
            bool(entry["random"]),
            entry["width"],
        )
        if case.name in known:
            probes.append(Probe(entry["rung"], full, known[case.name].examine))
        else:
            probes.append(replayed(entry["rung"], full))
    return precision, probes


def _write_case(folder: Path, precision: Precision, probe: Probe) -> None:
    case = probe.case
    outputs = expected(case, precision, probe.examine is examined_exactly)
    np.savez_compressed(folder / "in.npz", allow_pickle=False, **dict(case.inputs))
    np.savez_compressed(folder / "expected.npz", allow_pickle=False, **outputs)
    make_folder(folder / "expected")
    for name, array in outputs.items():
        (folder / "expected" / f"{name}.raw").write_bytes(array.tobytes())
    if case.width is not None and precision == "float32":
        parts = {f"in.{name}": array for name, array in case.inputs.items()}
        parts |= {f"expected.{name}": array for name, array in outputs.items()}
        write_frames(folder / "frame.exr", case.width, parts)


def _refuse_what_is_not_golden(folder: Path) -> None:
    if not folder.exists():
        return
    if not folder.is_dir():
        raise UsageError(f"--out {folder} is not a folder; name one")
    if any(folder.iterdir()) and not (folder / MANIFEST).exists():
        raise UsageError(
            f"--out {folder} holds something else than golden data; name another"
        )
