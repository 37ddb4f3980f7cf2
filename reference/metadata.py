"""What the header of a picture says about where it comes from."""

from collections.abc import Mapping

from reference.methods import Job, Method
from reference.options import as_text
from reference.scene.scene import Scene
from reference.version import project_version


def metadata(
    scene: Scene, method: Method, job: Job, rays: Mapping[str, int], seconds: float
) -> dict[str, str]:
    """Texts for the header of a picture.

    Parameters
    ----------
    scene : Scene
        Of which ``job.world`` was built.
    method : Method
        How; its name, and what biases its picture.
    job : Job
        What was rendered; all settings are told, also those left at their defaults,
        and the frame of an animated scene at which the picture begins.
    rays : mapping of str to int
        Traced, by kind.
    seconds : float, s
        Wall time of the rendering.

    Returns
    -------
    dict of str to str
        Scene, method, settings and version fix the pixels to the last bit.
    """
    words = {
        "scene": scene.name,
        "method": method.name,
        "fov": f"{scene.camera.fov!r} degrees",
        "fov_axis": scene.camera.fov_axis,
        "light": job.light,
        "bounces": str(job.bounces),
        "seed": str(job.seed),
        "frame": str(job.frame),
        **{name: str(count) for name, count in job.counts.items()},
        **{f"settings.{key}": text for key, text in as_text(job.settings).items()},
        "version": project_version(),
        "seconds": f"{seconds:.3f}",
        **{f"rays.{kind}": str(count) for kind, count in sorted(rays.items())},
    }
    if named := method.biases(job):
        words["biases"] = "; ".join(named)
    if scene.notes:
        words["scene.notes"] = " ".join(scene.notes)
    return words
