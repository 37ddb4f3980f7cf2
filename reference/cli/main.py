"""The command line: arguments in, exit code out, and never a traceback for bad input.

Exit codes:

==== ====================================================================
0    Done; of ``restir check`` PASS, QUICK, or nothing wrong that the
     baseline does not know.  Also help: ``restir`` alone is a question, not
     a mistake.
1    A verdict, and nothing else: FAIL of ``restir check``, or a picture
     beyond ``restir compare --tolerance``.
2    A wrong request, unreadable input, or trouble with this machine's
     files, memory or limits, told in one line on stderr.
3    UNDECIDED of ``restir check``.
70   A fault of this program.  ``RESTIR_TRACEBACK=1`` shows where.
130  Ctrl-C.
141  Nobody reads the output.
143  SIGTERM.
==== ====================================================================
"""

import argparse
import os
import sys
import traceback
from collections.abc import Iterable, Sequence
from contextlib import suppress
from importlib import import_module
from typing import Any, NoReturn

from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.signals import terminable
from restir_gi.reference.system.terminal import told_errors, visible
from restir_gi.reference.system.trouble import refuse_narrow_limits, trouble

BAD_USAGE, FAULT, INTERRUPTED, TERMINATED, BROKEN_PIPE = 2, 70, 130, 143, 141
TRACEBACK = "RESTIR_TRACEBACK"

COMMANDS = {
    "scenes": "the built-in scenes and what each requires; or export them.",
    "render": "make a picture with one method.",
    "reference": "accumulate the path-traced truth and its standard error.",
    "compare": "judge a picture against another one, the truth.",
    "demo": "path tracing, biased and unbiased ReSTIR GI, against the truth.",
    "golden": "inputs and expected outputs of every pass, for other backends.",
    "capture-template": "a folder to dump the buffers of an engine into.",
    "check": "the verdict on a backend, and the name of the bug.",
    "figures": "the figures of the papers, measured and drawn again.",
    "plan": "what a scene requires, what is left out, and what that changes.",
    "tradeoff": "speed against accuracy, measured, and what to take.",
    "inspect": "look into the reservoirs of a run.",
}
"""Each command's module and what it says of itself: known before it is imported."""


class Parser(argparse.ArgumentParser):
    """Parser whose errors are `UsageError`, and suggest what was meant."""

    def error(self, message: str) -> NoReturn:
        """Refuse the arguments.

        Raises UsageError.
        """
        raise UsageError(f"{message} (see {self.prog} --help)")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        from restir_gi.reference.system.suggestions import unknown

        kind = "command" if action.dest == "command" else "value"
        message = unknown(kind, str(value), map(str, action.choices))
        # Of a command its own name says where it stands.
        raise argparse.ArgumentError(None if kind == "command" else action, message)


class _Version(argparse.Action):
    """``--version``: its number takes a while to find, and is seldom asked for."""

    def __call__(self, parser: argparse.ArgumentParser, *rest: Any) -> NoReturn:
        from restir_gi.reference.system.version import project_version

        sys.stdout.write(f"restir-gi-oracle {project_version()}\n")
        parser.exit()


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional; arguments; those of the process if left out
    """
    try:
        return _run(sys.argv[1:] if argv is None else argv)
    except UsageError as error:
        return _tell(str(error), BAD_USAGE)
    except KeyboardInterrupt as stop:
        code = TERMINATED if getattr(stop, "terminated", False) else INTERRUPTED
        return _tell(str(stop) or "interrupted; nothing half-written is left", code)
    except BrokenPipeError:
        return BROKEN_PIPE
    # Whatever else is raised, by whomever: a SystemExit too is nobody's verdict.
    except BaseException as error:
        if os.environ.get(TRACEBACK, "0") not in ("", "0"):
            traceback.print_exc()
        if (told := trouble(error)) is not None:
            return _tell(told, BAD_USAGE)
        reason = f"{type(error).__name__}: {error}".removesuffix(": ")
        return _tell(
            f"internal error: {reason}; this is a fault of restir; set {TRACEBACK}=1"
            " to see where",
            FAULT,
        )


def build_parser(filled: Iterable[str] = COMMANDS) -> argparse.ArgumentParser:
    """Parser of the command line.

    Each of these commands has set ``run``, a function of the parsed arguments.

    Parameters
    ----------
    filled : iterable of str
        Commands whose arguments it knows; only their modules are imported.
    """
    parser = Parser(
        prog="restir",
        description="ReSTIR GI, its ground truth, and the difference between them.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "--version", action=_Version, nargs=0, help="show the version, and exit"
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, summary in COMMANDS.items():
        child = commands.add_parser(
            name,
            help=summary,
            description=summary,
            allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if name in filled:
            module_name = name.replace("-", "_")
            module = import_module(f"restir_gi.reference.cli.{module_name}")
            module.add_arguments(child)
            child.set_defaults(run=module.run)
    return parser


def _run(argv: Sequence[str]) -> int:
    for stream in (sys.stdout, sys.stderr):
        # A file name may hold bytes that are no text.
        with suppress(AttributeError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]

    # Options before the command take no value, so it is the first word that is none.
    # Nothing else is imported: NumPy, Embree and all commands take a second.
    command = next((word for word in argv if not word.startswith("-")), "")
    if command in COMMANDS:
        refuse_narrow_limits()
    parser = build_parser([command])
    try:
        with told_errors():
            arguments = parser.parse_args(argv or ["--help"])
    except SystemExit as stop:  # --help and --version
        return int(stop.code or 0)
    with terminable():
        return arguments.run(arguments) or 0


def _tell(message: str, code: int) -> int:
    if sys.stderr is not None:
        with suppress(OSError):
            sys.stderr.write(f"restir: {visible(' '.join(message.splitlines()))}\n")
            sys.stderr.flush()
    return code


if __name__ == "__main__":
    sys.exit(main())
