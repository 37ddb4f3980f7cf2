"""The one exception that means: the caller's input is wrong, not the program."""


class UsageError(Exception):
    """Bad input, told in one line: what is wrong, where, and what would be right.

    The command line prints the message and exits with 2; it never shows a traceback
    for one.  Line breaks in the message (file names may hold them) become spaces.
    """

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.splitlines()))
