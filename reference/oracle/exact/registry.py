"""All kernels of the matrix: those of this floor, and those of plug-ins."""

from collections.abc import Mapping
from functools import cache

from restir_gi.reference.oracle.exact.divisors import DIVISORS
from restir_gi.reference.oracle.exact.geometry import GEOMETRY
from restir_gi.reference.oracle.exact.kernel import Kernel
from restir_gi.reference.oracle.exact.materials import MATERIALS
from restir_gi.reference.oracle.exact.sampling import SAMPLING
from restir_gi.reference.oracle.exact.storage import STORAGE
from restir_gi.reference.oracle.exact.targets import TARGETS
from restir_gi.reference.oracle.exact.weights import WEIGHTS
from restir_gi.reference.system.plugins import find_plugin, plugin_names

GROUP = "restir.kernels"

OWN = (
    *TARGETS, *GEOMETRY, *WEIGHTS, *DIVISORS, *SAMPLING, *MATERIALS, *STORAGE,
)  # fmt: skip
"""Those of this floor."""


@cache
def kernels() -> tuple[Kernel, ...]:
    """All kernels.

    Those that packages register through the entry-point group ``restir.kernels`` come
    last.
    """
    names = plugin_names(GROUP)
    theirs = (find_plugin(GROUP, name, Kernel, "kernel") for name in names)
    return (*OWN, *(kernel for kernel in theirs if kernel is not None))


def limits_of(pass_name: str) -> dict[str, Mapping[str, str]]:
    """What the kernels of a pass define at their limits, by kernel and extreme.

    Empty for passes of which no kernel has any.
    """
    return {k.name: k.defines for k in kernels() if k.of_contract == pass_name}
