"""The commands of the command line, one a module, and what they share."""

COMMANDS = {
    "scenes": "list the built-in scenes and what each requires.",
    "render": "make a picture with one method.",
    "reference": "accumulate the path-traced truth and its standard error.",
    "compare": "judge a picture against another one, the truth.",
    "demo": "path tracing, biased and unbiased ReSTIR GI, against the truth.",
    "golden": "inputs and expected outputs of every pass, for other backends.",
    "check": "the verdict on a backend, and the name of the bug.",
    "figures": "the figures of the papers, measured and drawn again.",
    "plan": "what a scene requires, what is left out, and what that changes.",
    "tradeoff": "speed against accuracy, measured, and what to take.",
    "inspect": "look into the reservoirs of a run.",
}
"""Each command's module and what it says of itself: known before it is imported."""
