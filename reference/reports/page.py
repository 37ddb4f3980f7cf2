"""HTML pages that need nothing else: one file each, pictures and scripts inside."""

from base64 import b64encode
from collections.abc import Callable, Mapping
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

SHARED = "restir_gi.reference.reports"
"""Package of the frame ``page.html``, its style, and the macros of ``pieces.html``."""


def render_page(
    package: str,
    template: str,
    values: Mapping[str, Any],
    filters: Mapping[str, Callable[..., Any]] | None = None,
) -> bytes:
    """Fill in a template that extends ``page.html``.

    The page is whole before anything is written, so an older one stays whole when this
    one fails.

    The file: UTF-8, and a backslash escape for what has no UTF-8, as half a surrogate
    pair in the name of a file.

    Raises jinja2.UndefinedError: the template uses a name that is not given.

    Parameters
    ----------
    package : str; whose folder ``templates`` holds the template, and what it includes
    values : mapping of str to any
        Every name that the template uses; what it writes of them is escaped.
    """
    templates = Environment(
        loader=ChoiceLoader([PackageLoader(package), PackageLoader(SHARED)]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    templates.filters["base64"] = base64
    templates.filters.update(filters or {})
    text = templates.get_template(template).render(values)
    return text.encode(errors="backslashreplace")


def base64(data: bytes) -> str:
    """Bytes as the text in which a page carries them."""
    return b64encode(data).decode()
