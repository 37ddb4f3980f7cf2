"""Values on the command line: text in, a number within its limits out."""

import argparse
import re
from collections.abc import Callable

MOST_PIXELS_A_SIDE = 2**14
# Frames, samples and seeds are words of the random key.  Words that differ in higher
# bits alone have dependent streams (restir_gi.reference.numerics.rng).
MOST_SAMPLES = 2**27 - 1
MOST_SEED = 2**27 - 1
MOST_FRAMES = 256  # of a capture
MOST = 1e9
LEAST_LIMIT = 0.1  # seconds
Size = tuple[int, int]


def whole(least: int, most: int) -> Callable[[str], int]:
    """Make a converter from text to an integer within limits.

    It raises what argparse tells as an error.

    Parameters
    ----------
    least, most : int; both are allowed
    """

    def convert(text: str) -> int:
        # Digits as everybody writes them: int() also takes 1_000 and other scripts'.
        is_number = re.fullmatch(r"[+-]?\d{1,19}", text, re.ASCII)
        value = int(text) if is_number else least - 1
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(
                f"{text!r} is not an integer from {least} to {most}"
            )
        return value

    return convert


def words(text: str) -> frozenset[str]:
    """Words from text, with commas between them.

    Raises ArgumentTypeError: there is none, or an empty one.

    Parameters
    ----------
    text : str; "temporal,spatial"
    """
    found = [word.strip() for word in text.split(",")]
    if not all(found):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a list of names with a comma between each two"
        )
    return frozenset(found)


def frame_numbers(text: str) -> tuple[int, ...]:
    """Numbers of frames, one after the other.

    Raises ArgumentTypeError: it is no such range.

    Parameters
    ----------
    text : str; "0-3", or "7" for one frame
    """
    match = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", text, re.ASCII)
    first, last = (
        (int(number) for number in match.groups(match[1])) if match else (1, 0)
    )
    if not 0 <= last - first < MOST_FRAMES:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a range such as 0-3, of 1 to {MOST_FRAMES} frames"
        )
    return tuple(range(first, last + 1))


def size(text: str) -> Size:
    """Width and height from ``WxH``.

    Raises ArgumentTypeError: it is no such pair.

    Parameters
    ----------
    text : str; "640x480"

    Returns
    -------
    (int, int), pixels; 1 to 16384 each
    """
    match = re.fullmatch(r"(\d{1,9})[xX](\d{1,9})", text, re.ASCII)
    sides = tuple(int(side) for side in match.groups()) if match else (0, 0)
    if not all(1 <= side <= MOST_PIXELS_A_SIDE for side in sides):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not WIDTHxHEIGHT, each from 1 to {MOST_PIXELS_A_SIDE} pixels"
        )
    return sides[0], sides[1]


def tiled_size(text: str) -> Size:
    """Width and height of a picture that can be cut into 4 times 4 tiles.

    Raises ArgumentTypeError: it is no such pair.

    Parameters
    ----------
    text : str; "96x64", or "64" for both

    Returns
    -------
    (int, int), pixels; multiples of 4, from 8 to 4096
    """
    match = re.fullmatch(r"(\d{1,4})(?:[xX](\d{1,4}))?", text, re.ASCII)
    width, height = (int(side) for side in match.groups(match[1])) if match else (0, 0)
    if not all(8 <= side <= 4096 and side % 4 == 0 for side in (width, height)):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not WIDTHxHEIGHT, or one number for both, each a multiple of"
            " 4 from 8 to 4096"
        )
    return width, height


def amount(text: str) -> float:
    """A quantity from text: a time, a percentage, a bound.

    Raises ArgumentTypeError: it is no such number.

    Returns float; 0 to 10⁹.
    """
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= MOST:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 0 to {MOST:g}")
    return value


def share(text: str) -> float:
    """A share from text: 0.01 or 1%.

    Raises ArgumentTypeError: it is no such number.

    Returns float; above 0, at most 1.
    """
    number, percent = text.removesuffix("%"), text.endswith("%")
    try:
        value = float(number) / (100.0 if percent else 1.0)
    except ValueError:
        value = 0.0
    if not 0 < value <= 1:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no share, such as 0.01 or 1%, above 0 and at most 1"
        )
    return value


def seconds(text: str) -> float:
    """Time from text.

    Raises ArgumentTypeError: it is no such number.

    Returns float, s; 0 to 10⁹, some thirty years: clocks take no more.
    """
    try:
        return amount(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number of seconds from 0 to {MOST:g}"
        ) from error


def limit(text: str) -> float:
    """Time that one call may take, from text.

    Raises ArgumentTypeError: it is no such number.

    Returns float, s; at least `LEAST_LIMIT`.
    """
    value = seconds(text)
    if value < LEAST_LIMIT:
        raise argparse.ArgumentTypeError(
            f"{text!r} is less than {LEAST_LIMIT:g} s, which a process takes to start"
        )
    return value
