"""Mitsuba 3 scenes (.xml): sensor, lights, and all the rest together."""

import numpy as np

from restir_gi.reference.numerics.arrays import normalize
from restir_gi.reference.scene.camera import Camera, FovAxis
from restir_gi.reference.scene.loaders.framing import camera_or_framing, color, fov_axis
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.mitsuba_lights import MitsubaLights, add_light
from restir_gi.reference.scene.loaders.mitsuba_materials import Materials
from restir_gi.reference.scene.loaders.mitsuba_nodes import Node, mitsuba_session, parse
from restir_gi.reference.scene.loaders.mitsuba_shapes import (
    ReadShape,
    build_shape,
    plan_shapes,
)
from restir_gi.reference.scene.loaders.mitsuba_textures import Textures
from restir_gi.reference.scene.loaders.mitsuba_words import find
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere

OFFSETS = ("principal_point_offset_x", "principal_point_offset_y")
FULL_FRAME = float(np.hypot(36.0, 24.0))  # mm, the diagonal that focal lengths mean


def load(ledger: Ledger) -> Scene:
    """Scene of a Mitsuba 3 file.

    Integrator, sampler and reconstruction filter are no part of it.

    Raises UsageError: the package is missing, the file is not well-formed, or (unless
    lenient) it holds something that is not modelled.

    Parameters
    ----------
    ledger : Ledger; of the file: .xml; the files that it names are looked for beside it
    """
    with mitsuba_session() as mi:
        root = parse(mi, ledger)
        # All that the words say comes first: triangles may take long to read.
        textures = Textures(mi, ledger)
        materials = Materials(mi, ledger, textures)
        plans: list[ReadShape] = []
        for node in root.inside("shape"):
            plan_shapes(node, materials, plans)
        lights = MitsubaLights()
        for node in root.inside("emitter"):
            add_light(lights, node, textures)
        camera = _camera(root.inside("sensor"), ledger)
        ledger.settle()
        made = [build_shape(plan, materials) for plan in plans]
    ledger.settle()
    meshes = tuple(shape for shape in made if isinstance(shape, Mesh))
    spheres = tuple(shape for shape in made if isinstance(shape, Sphere))
    framed = camera_or_framing(camera, meshes, spheres, ledger)
    return Scene(
        name=ledger.path.stem,
        camera=framed,
        meshes=meshes,
        spheres=spheres,
        points=tuple(lights.points),
        spots=tuple(lights.spots),
        suns=tuple(lights.suns),
        environment=lights.environment,
        notes=tuple(ledger.notes),
    )


def _camera(sensors: list[Node], ledger: Ledger) -> Camera | None:
    if len(sensors) > 1:
        ledger.note(f"The first of {len(sensors)} sensors is used")
    if not sensors:
        return None
    sensor = sensors[0]
    if not sensor.is_modelled(ledger) and sensor.kind != "thinlens":
        return None
    width, height = _film(sensor, ledger)
    matrix = sensor.matrix(ledger)
    axes = matrix[:3, :3]
    if not np.allclose(axes.T @ axes, np.eye(3), atol=1e-3):
        ledger.replace(
            f"{sensor.name}: to_world scales or shears, which a camera cannot",
            "taken as the camera with the same view and up directions",
        )
    fov, axis = _fov(sensor, ledger)
    # Mitsuba's camera looks along +z of its frame, with +y up and +x to the left.
    _, up, forward = normalize(axes.T)
    camera = Camera(
        position=color(matrix[:3, 3]),
        target=color(matrix[:3, 3] + forward),
        up=color(up),
        fov=fov,
        fov_axis=axis,
        width=width,
        height=height,
        mirrored=bool(np.linalg.det(axes) < 0),
    )
    if sensor.kind == "perspective":
        sensor.check_words(ledger, apart=OFFSETS)
    for key in OFFSETS:
        if sensor.number(key, 0.0, ledger) != 0:
            sensor.refuse_word(key, find("perspective", key), ledger)
    return camera


def _film(sensor: Node, ledger: Ledger) -> tuple[int, int]:
    films = sensor.inside("film")
    if not films:
        return 768, 576
    film = films[0]
    if film.is_modelled(ledger):
        film.check_words(ledger)
    width, height = (
        int(film.number(key, default, ledger))
        for key, default in (("width", 768), ("height", 576))
    )
    return width, height


def _fov(sensor: Node, ledger: Ledger) -> tuple[float, FovAxis]:
    axis = fov_axis(sensor.name, sensor.get("fov_axis", "x"), ledger)
    fov, focal = sensor.get("fov"), sensor.get("focal_length")
    if fov is not None:
        return float(fov), axis
    # Mitsuba's default.
    with ledger.reading(f"focal length of {sensor.name}"):
        millimetres = float(str(focal or "50mm").removesuffix("mm"))
    return float(2 * np.degrees(np.arctan(FULL_FRAME / 2 / millimetres))), "diagonal"
