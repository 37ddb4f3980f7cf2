"""How exact each kernel is at its extremes, in 16, 32 and 64 bits."""
