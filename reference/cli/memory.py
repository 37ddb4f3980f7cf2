"""Whether a frame fits into memory, before it is begun."""

import os
from pathlib import Path

from restir_gi.reference.cli.values import MOST_PIXELS_A_SIDE
from restir_gi.reference.system.errors import UsageError

BYTES_A_PIXEL = 1024
"""What ReSTIR GI takes at its peak; path tracing takes less."""


def refuse_what_does_not_fit(width: int, height: int) -> None:
    """Raise unless a picture has a size, and a frame of it fits into memory.

    Raises UsageError: the message says how much there is.
    """
    if not (0 < width <= MOST_PIXELS_A_SIDE and 0 < height <= MOST_PIXELS_A_SIDE):
        raise UsageError(
            f"{width}x{height} is not a picture size; --size takes 1 to"
            f" {MOST_PIXELS_A_SIDE} pixels a side"
        )
    needed, free = width * height * BYTES_A_PIXEL, available_memory()
    if free is not None and needed > free:
        fits = int((free / BYTES_A_PIXEL) ** 0.5)
        raise UsageError(
            f"{width}x{height} pixels take about {needed / 2**30:.1f} GiB of memory and"
            f" {free / 2**30:.1f} GiB are free; ask for less, such as"
            f" --size {fits}x{fits}"
        )


def available_memory() -> int | None:
    """Memory that this process may still take.

    Returns int or None, bytes; None where the system does not tell.
    """
    found = [*_of_the_machine(), *_of_the_control_group()]
    return min(found) if found else None


def _of_the_machine() -> list[int]:
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return [int(line.split()[1]) * 1024]
        return [os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    except (OSError, ValueError, AttributeError):
        return []


def _of_the_control_group() -> list[int]:
    """What a container leaves, of which /proc/meminfo knows nothing."""
    folder = Path("/sys/fs/cgroup")
    try:
        most = int((folder / "memory.max").read_text(encoding="ascii"))
        used = int((folder / "memory.current").read_text(encoding="ascii"))
        lines = (folder / "memory.stat").read_text(encoding="ascii").splitlines()
        # Files that were read count as used, but give way.
        files = int(dict(line.split() for line in lines)["file"])
    except (OSError, ValueError, KeyError):  # no such file; or no limit, "max"
        return []
    return [max(most - used + files, 0)]
