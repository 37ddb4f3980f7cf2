"""Version of the installed project, for file headers."""

from importlib.metadata import PackageNotFoundError, version


def project_version() -> str:
    """Version of the project.

    "not installed" where the code runs from a bare checkout.
    """
    try:
        return version("restir-gi-oracle")
    except PackageNotFoundError:
        return "not installed"
