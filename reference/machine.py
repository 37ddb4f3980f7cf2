"""The machine that times belong to."""

import os
import platform

import numpy as np

from reference.version import project_version


def machine() -> dict[str, str]:
    """What the times belong to.

    Returns
    -------
    dict of str to str
        Processor, number of them, operating system, and versions.
    """
    return {
        "processor": platform.processor() or platform.machine(),
        "processors": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "version": project_version(),
    }
