"""What biases a picture: the settings that do, where the scene makes them matter."""

from collections.abc import Callable
from math import isfinite

from restir_gi.reference.scene.animation import Changes
from restir_gi.reference.scene.requirements import requirements
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.settings import Settings


def biases(settings: Settings, scene: Scene, changes: Changes) -> tuple[str, ...]:
    """Biases of ReSTIR GI, by name.

    Empty where the expectation of every frame is the truth.

    Parameters
    ----------
    scene : Scene; validated; which terms it wants decides which biases can show
    changes : 'nothing', 'camera' or 'scene'; what may differ between frames
    """
    needs = {r.name: r.why for r in requirements(scene)}
    moves = changes != "nothing"
    found = [words(settings, needs, moves) for words in _ALL]
    return tuple(words for words in found if words)


Needs = dict[str, str]


def _weights(s: Settings, needs: Needs, moves: bool) -> str:
    if s.mis != "1/M" or not (s.spatial or (moves and s.motion == "shifted")):
        return ""
    return "mis=1/M: dark where some neighbour could not have made the sample"


def _light_leaks(s: Settings, needs: Needs, moves: bool) -> str:
    told = s.visibility != "none" or s.final_visibility != "in-weight"
    if told or "occlusion between points" not in needs:
        return ""
    return "visibility=none: light leaks through what stands between"


def _glossy(s: Settings, needs: Needs, moves: bool) -> str:
    why = needs.get("sample points that are not Lambertian")
    if s.glossy_samples == "path-traced" or why is None:
        return ""
    return f"glossy_samples=as-lambertian: {why}"


def _past(s: Settings, needs: Needs, moves: bool) -> str:
    if not moves or not s.temporal or s.motion == "shifted":
        return ""
    validated = f", validated every {s.validate_every} frames" * (s.validate_every > 0)
    return f"motion=as-stored: what has moved or changed is reused as it was{validated}"


def _jacobian(s: Settings, needs: Needs, moves: bool) -> str:
    if s.jacobian == "multiplied":
        return ""
    return f"jacobian={s.jacobian}: samples keep the measure of where they were made"


def _limit(s: Settings, needs: Needs, moves: bool) -> str:
    if not isfinite(s.jacobian_limit) or s.beyond_limit == "reject-mirrored":
        return ""
    return f"beyond_limit={s.beyond_limit}: shifts are cut off, and no weight knows it"


def _age(s: Settings, needs: Needs, moves: bool) -> str:
    if not isfinite(s.max_age):
        return ""
    return "max_age: how long a sample is kept depends on its value"


def _boiling(s: Settings, needs: Needs, moves: bool) -> str:
    if s.boiling_filter == 0:
        return ""
    return "boiling_filter: bright reservoirs are emptied"


def _final(s: Settings, needs: Needs, moves: bool) -> str:
    if not moves or s.final_visibility != "reused":
        return ""
    return "final_visibility=reused: what is seen is what was seen a frame ago"


def _checkerboard(s: Settings, needs: Needs, moves: bool) -> str:
    if not moves or not s.checkerboard:
        return ""
    return "checkerboard: what only a new sample can find waits for its turn"


def _reduced_resolution(s: Settings, needs: Needs, moves: bool) -> str:
    if s.lattice == 1:
        return ""
    return f"lattice={s.lattice}: light that no reservoir nearby can see is missing"


def _storage(s: Settings, needs: Needs, moves: bool) -> str:
    return {
        "float64": "",
        "float32": "storage=float32: reservoirs are rounded to 24 bits a number",
        "half": "storage=half: reservoirs are rounded to 11 bits a number, places too",
        "paper": "storage=paper: reservoirs of 48 bytes, radiance rounded to 11 bits",
    }[s.storage]


_ALL: tuple[Callable[[Settings, Needs, bool], str], ...] = (
    _weights,
    _light_leaks,
    _glossy,
    _past,
    _jacobian,
    _limit,
    _age,
    _boiling,
    _final,
    _checkerboard,
    _reduced_resolution,
    _storage,
)
