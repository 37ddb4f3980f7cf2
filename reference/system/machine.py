"""The machine that times belong to."""

import os
import platform

import numpy as np

from restir_gi.reference.system.version import project_version


def machine() -> dict[str, str | int | None]:
    """What the times belong to.

    Processor, number of them, operating system, and versions.
    """
    return {
        "processor": platform.processor() or platform.machine(),
        "processors": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "version": project_version(),
    }
