"""All passes of the contract, by name."""

from reference.oracle.contract.fields import Passes
from reference.oracle.contract.kernels import KERNELS
from reference.oracle.contract.passes import FRAME_PASSES

CONTRACT: Passes = {p.name: p for p in (*KERNELS, *FRAME_PASSES)}
