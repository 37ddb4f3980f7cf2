"""``capture.toml``: read, and refused with all that is wrong with it."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from restir_gi.reference.oracle.capture.checks import faults_of_roles, faults_of_tables
from restir_gi.reference.oracle.capture.description import Manifest, described
from restir_gi.reference.oracle.capture.faults import CaptureError
from restir_gi.reference.oracle.capture.schema import faults_of_form
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file

NAME, MOST_BYTES = "capture.toml", 2**20


def read_manifest(path: Path) -> Manifest:
    """Read a manifest of files.

    Raises UsageError: it cannot be read, or is wrong; of what is wrong all is told.
    """
    try:
        data = tomllib.loads(read_file(path, MOST_BYTES).decode())
    except UnicodeDecodeError as error:
        raise UsageError(f"{path} is not text; write it in UTF-8") from error
    except RecursionError as error:
        raise UsageError(f"{path} is nested too deeply; write it flat") from error
    except ValueError as error:  # of TOML, and of numbers with thousands of digits
        raise UsageError(f"{path} is no TOML: {error}") from error
    return manifest_of(data, path, of_files=True)


def manifest_of(data: Mapping[str, Any], where: Path | str, of_files: bool) -> Manifest:
    """Judge a manifest.

    Raises CaptureError: it is wrong; all is told that is.

    Parameters
    ----------
    data : mapping; as TOML has it
    where : Path or str; how messages begin
    of_files : bool; buffers have files; else they are given as arrays
    """
    faults = faults_of_form(data) or list(faults_of_tables(data, of_files))
    if faults:
        raise CaptureError(where, faults)
    manifest = described(data)
    if faults := list(faults_of_roles(manifest)):
        raise CaptureError(where, faults)
    return manifest
