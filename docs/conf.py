"""Sphinx settings: ``sphinx-build -W -b html docs docs/_build/html``."""

import ast
import builtins
import dataclasses
import inspect
import re
import shutil
import subprocess
import sys
from importlib.metadata import version as installed_version
from pathlib import Path
from textwrap import dedent
from typing import Any

from docutils import nodes
from docutils.parsers.rst.states import Inliner
from sphinx.application import Sphinx

project = "restir-gi-oracle"
author = "the restir-gi-oracle authors"
project_copyright = f"2026, {author}"
version = release = installed_version(project)

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = [
    "_build",
    "_extra",
    "_templates",
    "gallery",
    "lessons/*.rst",
    "lessons/*.py",
]
templates_path = ["_templates"]

# Pages are Markdown with formulas, definition lists and headings to link to.
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# A module's page is made from its docstrings, and from signatures as the source spells
# them (`as_written`).  Pages of modules that are gone must not stay behind.
autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
shutil.rmtree(Path(__file__).parent / "reference" / "generated", ignore_errors=True)

# The gallery is run by the build; each script named plot_* makes its figures.
sphinx_gallery_conf = {
    "examples_dirs": ["gallery", "lessons"],
    "gallery_dirs": ["auto_gallery", "auto_lessons"],
    "filename_pattern": r"[\\/]plot_",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "within_subsection_order": "FileNameSortKey",
    "write_computation_times": False,  # its page fetches scripts from elsewhere
}

html_theme = "furo"
html_title = project
html_static_path = ["_static"]

# Pages that commands write; the folder is looked for before the build begins.
EXTRA = Path(__file__).parent / "_extra"
EXTRA.mkdir(exist_ok=True)
html_extra_path = [EXTRA.name]


def inspect_two_runs(app: Sphinx) -> None:
    """Make the inspector's page that the documentation leads to."""

    def restir(*words: str) -> None:
        # In the folder, so that the page does not name the machine's own.
        subprocess.run(
            [sys.executable, "-m", "restir_gi.reference", *words], cwd=EXTRA, check=True
        )

    size = ("--size", "32x32", "--frames", "6")
    for kind in ("unbiased", "biased"):
        method = ("--method", f"restir-gi-{kind}", "--out", f"{kind}.exr")
        restir("render", "cornell-box", *size, *method)
    restir("inspect", "unbiased.exr", "biased.exr", "--out", "inspector.html")
    for kind in ("unbiased", "biased"):
        (EXTRA / f"{kind}.exr").unlink()


class Named(ast.NodeTransformer):
    """Names types by their modules, for several may share a name."""

    def __init__(self, thing: Any) -> None:
        self._module = sys.modules[thing.__module__]

    def parsed(self, thing: Any) -> Any:
        """Definition of a class or function, in whose types names are full."""
        definition = ast.parse(dedent(inspect.getsource(thing))).body[0]
        for node in ast.walk(definition):
            for part in ("annotation", "returns"):
                hint = getattr(node, part, None)
                if isinstance(hint, ast.Constant) and isinstance(hint.value, str):
                    hint = ast.parse(hint.value, mode="eval").body
                if hint is not None:
                    setattr(node, part, self.visit(hint))
        return definition

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """``~package.module.Name``, of which the last part is shown."""
        if hasattr(builtins, node.id):
            return node
        found = getattr(self._module, node.id, None)
        owner = found if isinstance(found, type) else self._module
        full = f"{getattr(owner, '__module__', owner.__name__)}.{node.id}"
        return ast.UnaryOp(ast.Invert(), ast.Name(full))


def as_written(
    _: Sphinx, what: str, __: str, thing: Any, ___: Any, *signature: str | None
) -> tuple[str | None, ...]:
    """Signature with types as in the source: ``Vec3s``, not what it stands for."""
    try:
        if what == "class" and dataclasses.is_dataclass(thing):
            names = [field.name for field in dataclasses.fields(thing) if field.init]
            bases = filter(dataclasses.is_dataclass, reversed(thing.__mro__))
            fields = {
                ast.unparse(field.target): ast.unparse(field)
                for base in bases
                for field in Named(base).parsed(base).body
                if isinstance(field, ast.AnnAssign)
            }
            return f"({', '.join(fields[name] for name in names)})", None
        function = Named(thing).parsed(thing.__init__ if what == "class" else thing)
    except (AttributeError, KeyError, OSError, TypeError):
        return signature  # it is not written in Python
    if not isinstance(function, ast.FunctionDef):
        return signature
    arguments = function.args.args
    if arguments and arguments[0].arg in ("self", "cls"):
        del arguments[0]
    returns = function.returns and ast.unparse(function.returns)
    return f"({ast.unparse(function.args)})", returns if what != "class" else None


def setup(app: Sphinx) -> None:
    """Join the build."""
    app.connect("builder-inited", inspect_two_runs)
    app.connect("autodoc-process-signature", as_written)


def keep_bar(
    _: Inliner, match: re.Match[str], __: int
) -> tuple[str, list[nodes.Node], str, list[nodes.system_message]]:
    """Leave a vertical bar as it stands: |x| is an absolute value, no substitution."""
    end = match.end("start")
    return match.string[:end], [], match.string[end:], []


Inliner.dispatch["|"] = keep_bar
