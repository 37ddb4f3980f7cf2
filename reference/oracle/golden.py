"""Golden folders: inputs and expected outputs, for backends that are not here.

Beside the index and the raw buffers of :mod:`restir_gi.reference.oracle.raw` a folder
holds ``manifest.json``, and for each case ``in.npz``, ``expected.npz``,
``expected/*.raw`` and, where its rows are the pixels of an image, ``frame.exr`` with a
part for each buffer; of a case that a backend has failed ``found.npz`` is what it gave.
A backend writes ``out/*.raw``, or ``out.npz``, or ``out/out.exr``.
"""

import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.contract.surfaces import SURFACE
from restir_gi.reference.oracle.exact.registry import limits_of
from restir_gi.reference.oracle.exr_frames import write_frames
from restir_gi.reference.oracle.levels.declared import declared_kernel_probes
from restir_gi.reference.oracle.levels.exact import exact_outputs, examined_exactly
from restir_gi.reference.oracle.levels.grades import graded
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.lattice import every_enumeration, lattice_probes
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.levels.surfaces import surface_kernel_probes
from restir_gi.reference.oracle.parts import parts
from restir_gi.reference.oracle.raw import read_cases, write_cases
from restir_gi.reference.oracle.verdict import Verdict
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import make_folder, read_file, write_file
from restir_gi.reference.system.leftovers import scratch_folder, sweep
from restir_gi.reference.system.version import project_version

MANIFEST, FORM, FOUND = "manifest.json", "restir-golden 1", "found.npz"


def expected(
    case: Case, precision: Precision, exactly: bool = False
) -> dict[str, NDArray[Any]]:
    """What a case should give: in double precision, rounded once.

    Parameters
    ----------
    exactly : bool; of a kernel whose case is held against exact numbers

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
    found: Mapping[str, Buffers] | None = None,
) -> list[str]:
    """Write a golden folder.

    The new files are whole, in a hidden folder within this one, before the first old
    one is moved; an error moves all back.

    Returns the files that were kept: results of a backend, from the data that were
    replaced.

    Raises UsageError: the folder holds something else, or cannot be written.

    Parameters
    ----------
    folder : Path
        Does not exist, or is empty, or is a golden folder: what that lists in its
        manifest is replaced, and everything else in it is kept.
    about : dict; what the manifest says of scene, size and seed
    tell : callable; told how many cases are done, of how many
    found : mapping of str to Buffers, optional
        What a backend gave for a case, which is kept beside what it should give.
    """
    is_new = False
    try:
        old = _files_of_ours(folder)
        is_new = not folder.exists()
        make_folder(folder)
        with scratch_folder("golden", folder) as space:
            new = space / "new"
            cases = [probe.case for probe in probes]
            write_cases(new, passes, precision, cases)
            for number, probe in enumerate(probes):
                place = new / probe.case.name
                _write_case(place, precision, probe)
                if (outputs := (found or {}).get(probe.case.name)) is not None:
                    np.savez_compressed(place / FOUND, allow_pickle=False, **outputs)
                tell(number + 1, len(probes), "cases")
            manifest = {
                "form": FORM,
                "version": project_version(),
                "precision": precision,
                **about,
                "limits": {name: limits_of(name) for name in passes if limits_of(name)},
                "cases": [_entry(probe) for probe in probes],
            }
            _replace(folder, space, old, manifest)
        kept = set(_files_below(folder)) - {*manifest["files"]}
    except OSError as error:
        raise UsageError(f"cannot write {folder}: {error.strerror}") from error
    finally:
        if is_new:
            with suppress(OSError):  # it is in use, unless nothing came of it
                folder.rmdir()
    return sorted(kept)


def write_failing(
    folder: Path, passes: Passes, verdict: Verdict, backend: str
) -> list[str]:
    """Keep the cases that are wrong as a golden folder, with what the backend gave.

    Those that are wrong at extremes alone are among them.

    Returns the names of the cases; where there are none, nothing is written.

    Raises UsageError: the folder holds something else, or cannot be written.

    Parameters
    ----------
    backend : str; as the manifest names it
    """
    wrong = {
        answer.probe.case.name: answer
        for timed in verdict.steps
        for answer in timed.step.answers
        if answer.finding and (not answer.finding.passed or answer.finding.at_extremes)
    }
    if wrong:
        write_golden(
            folder,
            passes,
            verdict.precision,
            [answer.probe for answer in wrong.values()],
            {"failed": backend},
            lambda done, total, unit: None,
            {name: a.outputs for name, a in wrong.items() if a.outputs is not None},
        )
    return list(wrong)


def read_golden(folder: Path) -> tuple[Precision, list[Probe]]:
    """Questions of a golden folder.

    Raises UsageError: it is none.

    Parameters
    ----------
    folder : Path; as `write_golden` left it

    Returns
    -------
    precision : 'float32' or 'float64'; of the inputs
    probes : list of Probe; with the inputs as they stand in the files
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
    declared = any(SURFACE.name in case.settings for case in cases)
    known = {
        probe.case.name: probe
        for probe in (
            *kernel_probes(precision),
            *declared_kernel_probes(precision),
            *(surface_kernel_probes(precision) if declared else ()),
            *lattice_probes(precision, every_enumeration()),
            *row_probes(precision),
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
            examine = known[case.name].examine
            probes.append(Probe(entry["rung"], graded(full), examine))
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


def _entry(probe: Probe) -> dict[str, Any]:
    case = probe.case
    return {
        "name": case.name,
        "pass": case.pass_name,
        "rung": probe.level,
        "rows": case.rows,
        "random": case.random,
        "width": case.width,
    }


def _files_of_ours(folder: Path) -> list[str]:
    """Files that a folder lists in its manifest; or raise if it is a foreign one."""
    if not folder.exists():
        return []
    if not folder.is_dir():
        raise UsageError(f"{folder} is not a folder; name one")
    sweep(folder)
    try:
        if not any(folder.iterdir()):
            return []
        manifest = json.loads(read_file(folder / MANIFEST))
        if manifest["form"] != FORM:
            raise ValueError
    except (UsageError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise UsageError(
            f"{folder} holds other files than golden data; name another"
        ) from error
    listed = manifest.get("files")
    if not isinstance(listed, list) or not all(isinstance(n, str) for n in listed):
        raise UsageError(
            f"{folder} comes from a version that did not list its files; delete"
            " it, or name another"
        )
    return [name for name in listed if _is_ours(folder, name)]


def _is_ours(folder: Path, name: str) -> bool:
    """Whether a name in a manifest is a file in this folder, and no result."""
    path = PurePosixPath(name)
    above = [folder / part for part in path.parents if part.name]
    return (
        not path.is_absolute()
        and ".." not in path.parts
        and path.parts[1:2] != ("out",)
        and not any(part.is_symlink() for part in above)
        and (folder / path).is_file()
    )


def _replace(
    folder: Path, space: Path, old: list[str], manifest: dict[str, Any]
) -> None:
    """Move old files aside, and new ones in; the manifest is the last.

    After a kill the folder has a manifest that lists all that may be of ours, so that
    the next run can replace it, and no cases, so that nobody reads it.
    """
    made = _files_below(space / "new")
    manifest["files"] = [*made, MANIFEST]
    for name in made:
        if name not in old and os.path.lexists(folder / name):
            raise UsageError(
                f"{folder} holds {name}, which is not golden data; name another"
            )
    last = folder / MANIFEST
    before = read_file(last) if last.exists() else None
    between = {"form": FORM, "files": sorted({*old, *made, MANIFEST})}
    moves = [(folder / n, space / "old" / n) for n in old if n != MANIFEST]
    moves += [(space / "new" / n, folder / n) for n in made]
    done: list[tuple[Path, Path]] = []
    try:
        write_file(last, json.dumps(between).encode())
        for here, there in moves:
            _move(here, there)
            done.append((here, there))
        _remove_empty_folders(folder, old)
        for entry in manifest["cases"]:
            (folder / entry["name"] / "out").mkdir(exist_ok=True)
        write_file(last, json.dumps(manifest, indent=1).encode())
    except BaseException:  # Ctrl-C too
        for here, there in reversed(done):
            _move(there, here)
        last.unlink() if before is None else write_file(last, before)
        raise


def _move(here: Path, there: Path) -> None:
    there.parent.mkdir(parents=True, exist_ok=True)
    here.rename(there)


def _remove_empty_folders(folder: Path, old: list[str]) -> None:
    above = {path for name in old for path in PurePosixPath(name).parents if path.name}
    above |= {path / "out" for path in above if len(path.parts) == 1}
    for path in sorted(above, reverse=True):
        with suppress(OSError):  # something is in it
            (folder / path).rmdir()


def _files_below(folder: Path) -> list[str]:
    return sorted(
        (Path(above) / name).relative_to(folder).as_posix()
        for above, _, names in os.walk(folder)
        for name in names
    )
