"""What a picture shows: which light, and which part of a pixel."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from restir_gi.reference.transport.accumulate import Pixel
from restir_gi.reference.transport.path_tracer import MAX_BOUNCES, Light

SEEN = {
    "center": "through the centres of pixels",
    "box": "averaged over the squares of pixels",
}


@dataclass(frozen=True, slots=True)
class Convention:
    """What a picture shows.

    Attributes
    ----------
    light : 'indirect', 'direct' or 'full'; which paths count
    bounces : int; surface points that a path may visit after the first
    pixel : 'center' or 'box'; where camera rays pass through a pixel
    """

    light: Light = "indirect"
    bounces: int = 1
    pixel: Pixel = "center"

    @property
    def words(self) -> str:
        """What it is, for a sentence."""
        light = f"{self.light} light"
        if self.light != "direct":
            many = "bounce" if self.bounces == 1 else "bounces"
            light += f" of {self.bounces} {many}"
        return f"{light}, {SEEN[self.pixel]}"

    @property
    def options(self) -> str:
        """What asks for it on the command line."""
        words = f"--light {self.light}"
        if self.light != "direct":
            words += f" --bounces {self.bounces}"
        return f"{words} --pixel {self.pixel}"

    def others(self) -> Iterator["Convention"]:
        """Those that a renderer may have followed by mistake: one thing is another."""
        yield replace(self, pixel="box" if self.pixel == "center" else "center")
        if self.light != "direct":
            for bounces in (self.bounces - 1, self.bounces + 1):
                if 1 <= bounces <= MAX_BOUNCES:
                    yield replace(self, bounces=bounces)
        lights: tuple[Light, ...] = ("indirect", "direct", "full")
        for light in lights:
            if light != self.light:
                yield replace(self, light=light)
