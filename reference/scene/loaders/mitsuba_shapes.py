"""Mitsuba's shapes: first what they are, then their triangles."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.loaders.framing import color
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.mitsuba_materials import (
    Materials,
    MitsubaAppearance,
)
from restir_gi.reference.scene.loaders.mitsuba_meshes import FILES, read_mesh
from restir_gi.reference.scene.loaders.mitsuba_nodes import Node, check_matrix
from restir_gi.reference.scene.loaders.triangles import drop_texture_without_uv, place
from restir_gi.reference.scene.materials.kinds import Dielectric, Lambertian
from restir_gi.reference.scene.shapes import Mesh, Sphere
from restir_gi.reference.scene.textures import Pattern, Texture, mean_color, shines
from restir_gi.reference.system.errors import UsageError

BYTES = 2**14
"""Of memory for a shape without its triangles, generously."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadShape:
    """A shape whose words were read, without its triangles.

    Attributes
    ----------
    matrix : (4, 4) float64; its own frame to world
    look : MitsubaAppearance; how it scatters, and where
    emission : Texture; radiance of its front
    path : Path or None; the file of its triangles
    turn : (2, 3) float64 or None; what becomes of its texture coordinates
    """

    node: Node
    matrix: Scalars
    look: MitsubaAppearance
    emission: Texture
    path: Path | None
    turn: Scalars | None = None

    @property
    def patterns(self) -> list[Pattern]:
        """All its textures."""
        material = self.look.material
        textures = [self.emission, self.look.opacity]
        if not isinstance(material, Dielectric):
            textures.insert(0, material.reflectance)
        return [texture for texture in textures if isinstance(texture, Pattern)]


def plan_shapes(
    node: Node,
    materials: Materials,
    plans: list[ReadShape],
    outer: Scalars | None = None,
) -> None:
    """Read the words of a shape and of those inside it.

    Parameters
    ----------
    plans : list of ReadShape; grows, by each shape that is not left out, which is noted
    outer : (4, 4) float64 or None; what an instance does with it
    """
    ledger = materials.ledger
    if not node.is_modelled(ledger):
        return
    node.check_words(ledger)
    ledger.take(BYTES, f"{node.name} is one of very many shapes")
    matrix = node.matrix(ledger)
    if outer is not None:
        matrix = outer @ matrix
        check_matrix(matrix, f"{node.name}: with its instance, its place", ledger)
    if node.kind == "shapegroup":
        return  # only its instances are seen
    if node.kind in ("instance", "merge"):
        for group in node.inside("shape"):
            inner = group.inside("shape") if group.kind == "shapegroup" else [group]
            for shape in inner:
                plan_shapes(shape, materials, plans, matrix)
    elif plan := _plan(node, matrix, materials):
        plans.append(plan)


def _plan(node: Node, matrix: Scalars, materials: Materials) -> ReadShape | None:
    ledger = materials.ledger
    path = None
    if node.kind in FILES:
        try:
            path = node.file(ledger)
        except UsageError as error:
            ledger.replace(f"{node.name}: {error}", "left out")
    emission = _emission(node, materials)
    look = _look(node, materials, shines(emission))
    if look is None or (node.kind in FILES and path is None):
        return None
    if node.kind == "sphere":
        emission = _plain(node, emission, ledger)
        look = _plain_look(node, look, ledger)
    plan = ReadShape(node, matrix, look, emission, path)
    turn = materials.textures.placement(plan.patterns, node.name)
    return replace(plan, turn=turn)


def _look(node: Node, materials: Materials, emits: bool) -> MitsubaAppearance | None:
    bsdfs = node.inside("bsdf")
    if not bsdfs:
        # Mitsuba's defaults: lamps are black, other shapes half white.
        grey = (0.0,) * 3 if emits else (0.5,) * 3
        return MitsubaAppearance(Lambertian(grey, two_sided=False))
    look = materials.of(bsdfs[0])
    if look is None and emits:
        materials.ledger.replace(
            f"{node.name} is invisible and emits, which is not modelled", "left out"
        )
    return look


def _emission(node: Node, materials: Materials) -> Texture:
    for emitter in node.inside("emitter"):
        if emitter.kind != "area":
            materials.ledger.replace(
                f"{emitter.name} on {node.name} is not modelled (area is)", "ignored"
            )
            continue
        emitter.check_words(materials.ledger)
        return materials.textures.read(emitter, "radiance", 1.0, emission=True)
    return 0.0, 0.0, 0.0


def _plain(node: Node, texture: Texture, ledger: Ledger) -> Texture:
    if not isinstance(texture, Pattern):
        return texture
    ledger.replace(
        f"{node.name}: a texture on a sphere lies otherwise in Mitsuba",
        "taken in the mean colour of the texture",
    )
    return color(mean_color(texture))


def _plain_look(
    node: Node, look: MitsubaAppearance, ledger: Ledger
) -> MitsubaAppearance:
    if look.opacity is not None:
        ledger.replace(f"{node.name}: a mask on a sphere is not modelled", "left whole")
    if look.attribute:
        ledger.replace(
            f'{node.name} has no attribute "{look.attribute}"', "taken as white"
        )
    material = look.material
    if not isinstance(material, Dielectric):
        plain = _plain(node, material.reflectance, ledger)
        if plain is not material.reflectance:
            material = replace(material, reflectance=plain)
    return MitsubaAppearance(material)


def build_shape(plan: ReadShape, materials: Materials) -> Mesh | Sphere:
    """The shape of a plan, with its triangles, in the world."""
    ledger = materials.ledger
    if plan.node.kind == "sphere":
        return _sphere(plan, ledger)
    look = plan.look
    if plan.path is not None and plan.path not in materials.weighed:
        materials.weighed.add(plan.path)
        ledger.read(str(plan.path))  # counted for what the scene may take
    mesh = read_mesh(
        materials.mi,
        plan.node,
        plan.matrix,
        plan.path,
        look.attribute,
        bool(plan.patterns),
        ledger,
    )
    if look.attribute and mesh.colors is None:
        ledger.replace(
            f'{plan.node.name} has no attribute "{look.attribute}"', "taken as white"
        )
    if plan.turn is not None and mesh.uv is not None:
        mesh = replace(mesh, uv=mesh.uv @ plan.turn[:, :2].T + plan.turn[:, 2])
    mesh = replace(
        mesh, material=look.material, emission=plan.emission, opacity=look.opacity
    )
    return drop_texture_without_uv(mesh, ledger)


def _sphere(plan: ReadShape, ledger: Ledger) -> Sphere:
    node, matrix = plan.node, plan.matrix
    scales = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.allclose(scales, scales[0], rtol=1e-4):
        ledger.replace(
            f"{node.name} is stretched by its to_world, which is not modelled",
            "taken as a sphere of the mean radius",
        )
    center = node.point("center", np.zeros(3), ledger)
    # Unlike on other shapes, in Mitsuba a mirrored sphere is turned inside out.
    mirrored = bool(np.linalg.det(matrix[:3, :3]) < 0)
    return Sphere(
        name=node.id,
        center=color(place(center[None], matrix)[0]),
        radius=float(node.number("radius", 1.0, ledger) * scales.mean()),
        material=plan.look.material,
        emission=plan.emission,
        inward=mirrored != node.flag("flip_normals", False, ledger),
    )
