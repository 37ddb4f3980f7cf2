"""Methods: how a picture is made, and what they are called on the command line."""

from restir_gi.reference.methods.discovery import method_named, method_names
from restir_gi.reference.methods.method import (
    Job,
    Layers,
    Method,
    Progress,
    Rendering,
    Shown,
    drive,
)

__all__ = [
    "Job",
    "Layers",
    "Method",
    "Progress",
    "Rendering",
    "Shown",
    "drive",
    "method_named",
    "method_names",
]
