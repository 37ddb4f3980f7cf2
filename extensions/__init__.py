"""The floor of what the upper methods share.

Path records, shift mappings between pixels (reconnection, random replay, and the
hybrid of both), the weights of generalized resampling, whole-path reservoirs, and
reservoirs over the area of a pixel.  It stands on ``reference`` and imports nothing
from ``hashgrid`` or ``gradient_domain``.
"""
