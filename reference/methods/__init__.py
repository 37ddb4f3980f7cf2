"""Methods: how a picture is made, and what they are called on the command line."""

from reference.methods.discovery import method_named, method_names
from reference.methods.method import (
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
