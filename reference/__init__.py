"""ReSTIR GI in whole-frame NumPy: the algorithm, its scenes and its ground truth."""
