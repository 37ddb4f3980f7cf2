"""Both forms of a scene, and a built-in scene in the state of one frame."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.exporters.gltf import gltf_files, gltf_unsaid
from restir_gi.reference.scene.exporters.mitsuba import mitsuba_files, mitsuba_unsaid
from restir_gi.reference.scene.named import Named, frames_of
from restir_gi.reference.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Form:
    """A form of scene file.

    Attributes
    ----------
    unsaid : callable; what it cannot say of a scene, a clause each
    files : callable; contents by name, the file to open last
    """

    name: str
    unsaid: Callable[[Scene], Iterator[str]]
    files: Callable[[Scene], dict[str, bytes]]


FORMS = (
    Form("glTF", gltf_unsaid, gltf_files),
    Form("Mitsuba XML", mitsuba_unsaid, mitsuba_files),
)


@dataclass(frozen=True, slots=True)
class Exported:
    """A scene as files.

    Attributes
    ----------
    files : dict; contents by name, in the order in which they are to be written
    refused : dict; by the name of a form, one line that says why it cannot be written
    """

    name: str
    files: dict[str, bytes]
    refused: dict[str, str]


def exported(scene: Scene) -> Exported:
    """Files of all forms that can say the whole scene.

    Parameters
    ----------
    scene : Scene; validated
    """
    files: dict[str, bytes] = {}
    refused: dict[str, str] = {}
    for form in FORMS:
        clauses = dict.fromkeys(form.unsaid(scene))
        if clauses:
            told = "; ".join(clauses)
            refused[form.name] = f"{scene.name} cannot be said in {form.name}: {told}"
        else:
            files |= form.files(scene)
    return Exported(scene.name, files, refused)


def built_in_scene(name: str, frame: int) -> Scene:
    """A built-in scene in one frame, validated.

    Raises UsageError: there is no scene of that name.
    """
    scene = find_scene(name)
    size = scene.camera.width, scene.camera.height
    return frames_of(Named(name, False, *size, frame), scene)(0)
