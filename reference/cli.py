"""The command line: arguments in, exit code out, and never a traceback for bad input.

Exit codes: 0 success; 1 and 3 of ``restir check``: the backend is wrong, or it is
undecided; 2 a wrong request or unreadable input, told in one line on
stderr; 130 after Ctrl-C and 143 after SIGTERM; 141 where nobody reads the output.
"""

import argparse
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

from reference.errors import UsageError

BAD_USAGE, INTERRUPTED, TERMINATED, BROKEN_PIPE = 2, 130, 143, 141


class Parser(argparse.ArgumentParser):
    """Parser whose errors are `UsageError`."""

    def error(self, message: str) -> NoReturn:
        """Refuse the arguments.

        Parameters
        ----------
        message : str
            What is wrong.

        Raises
        ------
        UsageError
            Always.
        """
        raise UsageError(f"{message} (see {self.prog} --help)")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process if left out.

    Returns
    -------
    int
        Exit code.
    """
    try:
        return _run(argv)
    except UsageError as error:
        return _tell(str(error), BAD_USAGE)
    except MemoryError:
        return _tell("out of memory; ask for a smaller --size", BAD_USAGE)
    except BrokenPipeError:
        return BROKEN_PIPE
    except KeyboardInterrupt as stop:
        code = TERMINATED if getattr(stop, "terminated", False) else INTERRUPTED
        return _tell(str(stop) or "interrupted; nothing half-written is left", code)


def build_parser() -> argparse.ArgumentParser:
    """Parser of the whole command line.

    Returns
    -------
    argparse.ArgumentParser
        Each command has set ``run``, a function of the parsed arguments.
    """
    # Imported here, where a Ctrl-C is caught: NumPy and Embree take a while to load.
    from reference.commands import (
        check,
        compare,
        demo,
        figures,
        golden,
        inspect,
        plan,
        reference,
        render,
        scenes,
        tradeoff,
    )
    from reference.version import project_version

    parser = Parser(
        prog="restir",
        description="ReSTIR GI, its ground truth, and the difference between them.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "--version", action="version", version=f"restir-gi-oracle {project_version()}"
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    modules = (scenes, render, reference, compare, demo, golden, check, figures)
    for module in (*modules, plan, tradeoff, inspect):
        summary = (module.__doc__ or "").partition("\n")[0].partition(": ")[2]
        child = commands.add_parser(
            module.NAME,
            help=summary,
            description=summary,
            allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        module.add_arguments(child)
        child.set_defaults(run=module.run)
    return parser


def _run(argv: Sequence[str] | None) -> int:
    for stream in (sys.stdout, sys.stderr):
        # A file name may hold bytes that are no text.
        with suppress(AttributeError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    parser = build_parser()
    from reference.commands.console import told_errors
    from reference.signals import terminable

    try:
        with told_errors():
            arguments = parser.parse_args(argv)
    except SystemExit as stop:  # --help and --version
        return int(stop.code or 0)
    with terminable():
        return arguments.run(arguments) or 0


def _tell(message: str, code: int) -> int:
    if sys.stderr is not None:
        with suppress(OSError):
            sys.stderr.write(f"restir: {message}\n")
            sys.stderr.flush()
    return code


if __name__ == "__main__":
    sys.exit(main())
