"""All passes of the contract, by name."""

from restir_gi.reference.oracle.contract.fields import Passes
from restir_gi.reference.oracle.contract.kernels import KERNELS
from restir_gi.reference.oracle.contract.passes import FRAME_PASSES

CONTRACT: Passes = {p.name: p for p in (*KERNELS, *FRAME_PASSES)}
