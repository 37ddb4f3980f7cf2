"""What the header of a picture says about where it comes from."""

from collections.abc import Mapping
from dataclasses import asdict, fields

from restir_gi.reference.methods import Job, Method
from restir_gi.reference.methods.setting_values import text_of
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.fingerprint import fingerprint
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.system.version import project_version

Words = Mapping[str, str | int | float | bool]


def metadata(
    scene: Scene, method: Method, job: Job, rays: Mapping[str, int], seconds: float
) -> Words:
    """What a picture is of, and how it was made.

    Parameters
    ----------
    scene : Scene; of which ``job.world`` was built
    method : Method; how; its name, and what biases its picture
    job : Job
        What was rendered; all settings are told, also those left at their defaults,
        and the frame of an animated scene at which the picture begins.
    seconds : float, s; wall time of the rendering

    Returns
    -------
    mapping of str to str, int, float or bool
        Scene, method, settings and version fix the pixels to the last bit.  What
        ``"shown"`` is of: the frame that is seen, a digest of all that is in it, and
        from where, by which pictures are found to be of the same thing.
    """
    frames = job.counts.get("frames", 1)
    shown = job.animation(frames - 1) if job.animation and frames > 1 else scene
    words: dict[str, str | int | float | bool] = {
        "scene": scene.name,
        "method": method.name,
        "light": job.light,
        "bounces": job.bounces,
        "seed": job.seed,
        "frame": job.frame,
        **job.counts,
        **{f"settings.{key}": value for key, value in asdict(job.settings).items()},
        "shown.frame": job.frame + frames - 1,
        "shown.scene": _content(shown),
        "shown.view": _view(shown.camera),
        "shown.pixel": getattr(job.settings, "pixel", method.pixel),
        "version": project_version(),
        "seconds": round(seconds, 3),
        **{f"rays.{kind}": count for kind, count in sorted(rays.items())},
    }
    if named := method.biases(job):
        words["biases"] = "; ".join(named)
    if scene.notes:
        words["scene.notes"] = " ".join(scene.notes)
    return words


def header(words: Words) -> dict[str, str]:
    """The same as text, which is what a file holds."""
    return {key: text_of(value) for key, value in words.items()}


def _content(scene: Scene) -> str:
    """Digest of all that light meets: not of the eye, nor of what it is called."""
    beside = ("name", "camera", "notes")
    parts = [getattr(scene, f.name) for f in fields(scene) if f.name not in beside]
    return fingerprint(parts)[:16]


def _view(camera: Camera) -> str:
    position, target, up = (
        " ".join(f"{number:.9g}" for number in vector)
        for vector in (camera.position, camera.target, camera.up)
    )
    return (
        f"from {position} to {target}, up {up}, {camera.fov:.9g} degrees of"
        f" {camera.fov_axis}, {camera.width}x{camera.height}"
        + (", mirrored" if camera.mirrored else "")
    )
