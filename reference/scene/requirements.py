"""What a scene requires of the model, who asks for it, and what it can do without."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from restir_gi.reference.scene.convexity import first_obstacle
from restir_gi.reference.scene.lights import ConstantEnvironment
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
)
from restir_gi.reference.scene.materials.parameters import Kind, kind_of
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere, emits
from restir_gi.reference.scene.textures import Pattern, color_range

Shape = Mesh | Sphere

SHOWN = 3
"""Shapes named one by one before the rest is counted."""


@dataclass(frozen=True, slots=True)
class Requirement:
    """One feature of the model, and whether a scene needs it.

    Attributes
    ----------
    why : str
        Which shape, material or light asks for it; what it does without it, where it
        is left out.
    left_out : bool; the scene does not need it
    """

    name: str
    why: str
    left_out: bool = False


def requirements(scene: Scene) -> tuple[Requirement, ...]:
    """Features that a scene needs, each with who asks, in the order of :func:`survey`.

    Parameters
    ----------
    scene : Scene; validated
    """
    return tuple(r for r in survey(scene) if not r.left_out)


def left_out(scene: Scene) -> tuple[Requirement, ...]:
    """Features that a scene does not need, and why not, in the order of :func:`survey`.

    Parameters
    ----------
    scene : Scene; validated
    """
    return tuple(r for r in survey(scene) if r.left_out)


def survey(scene: Scene) -> tuple[Requirement, ...]:
    """All features of the model, needed by a scene or not.

    Always the same names in the same order: shapes, materials, lights, and what follows
    from them.

    Parameters
    ----------
    scene : Scene; validated
    """
    found = [(name, asks(scene), without) for name, asks, without in _FEATURES]
    return tuple(
        Requirement(name, why or without, left_out=not why)
        for name, why, without in found
    )


def _shapes(scene: Scene) -> tuple[Shape, ...]:
    return (*scene.meshes, *scene.spheres)


def _listed(shapes: Iterable[Shape]) -> str:
    names = [
        f'{"mesh" if isinstance(shape, Mesh) else "sphere"} "{shape.name}"'
        for shape in shapes
    ]
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")


def _made_of(test: Callable[[Material], bool]) -> Callable[[Scene], str]:
    return lambda scene: _listed(s for s in _shapes(scene) if test(s.material))


def _is_textured(material: Material) -> bool:
    return not isinstance(material, Dielectric) and isinstance(
        material.reflectance, Pattern
    )


def _is_one_sided(material: Material) -> bool:
    return not getattr(material, "two_sided", True)


def _has_delta_lobe(material: Material) -> bool:
    kinds = (Kind.SMOOTH_CONDUCTOR, Kind.SMOOTH_COATED, Kind.DIELECTRIC)
    return kind_of(material) in kinds


def _is_diffuse(material: Material) -> bool:
    return isinstance(material, Lambertian) and color_range(material.reflectance)[1] > 0


def _is_glossy(material: Material) -> bool:
    """Whether it scatters light, and not alike into all directions."""
    if isinstance(material, Conductor):
        return color_range(material.reflectance)[1] > 0
    return not isinstance(material, Lambertian)


def _smooth(scene: Scene) -> str:
    return _listed(mesh for mesh in scene.meshes if mesh.normals is not None)


def _area_lights(scene: Scene) -> str:
    return _listed(shape for shape in _shapes(scene) if emits(shape))


def _glows_unevenly(shape: Shape) -> bool:
    return emits(shape) and isinstance(shape.emission, Pattern)


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'s' if number > 1 else ''}" if number else ""


def _environment(scene: Scene) -> str:
    if scene.environment is None:
        return ""
    constant = isinstance(scene.environment, ConstantEnvironment)
    return "an even sky" if constant else "a map of the sky"


def _chance(scene: Scene) -> str:
    found = (_area_lights(scene), _environment(scene))
    return ", ".join(words for words in found if words)


def _glossy_samples(scene: Scene) -> str:
    shapes = _listed(s for s in _shapes(scene) if _is_glossy(s.material))
    text = "what leaves it is not the same in all directions, as reuse takes it to be"
    return f"{shapes}: {text}" if shapes else ""


def _occlusion(scene: Scene) -> str:
    obstacle = first_obstacle(scene)
    return "" if obstacle is None else f"{_listed([obstacle])} may stand between points"


_FEATURES: tuple[tuple[str, Callable[[Scene], str], str], ...] = (
    ("triangles", lambda s: _listed(s.meshes), "no mesh"),
    ("spheres", lambda s: _listed(s.spheres), "no analytic sphere"),
    ("smooth normals", _smooth, "all faces are flat"),
    ("textures", _made_of(_is_textured), "one colour a material"),
    (
        "vertex colours",
        lambda s: _listed(m for m in s.meshes if m.colors is not None),
        "no mesh has colours at its vertices",
    ),
    (
        "alpha masks",
        lambda s: _listed(m for m in s.meshes if m.opacity is not None),
        "no mesh has holes",
    ),
    ("one-sided materials", _made_of(_is_one_sided), "both sides scatter alike"),
    ("Lambertian surfaces", _made_of(_is_diffuse), "nothing diffuse"),
    (
        "rough conductors",
        _made_of(lambda m: kind_of(m) == Kind.ROUGH_CONDUCTOR),
        "no rough metal",
    ),
    ("coats", _made_of(lambda m: isinstance(m, Coated)), "nothing is coated"),
    ("delta lobes", _made_of(_has_delta_lobe), "nothing is perfectly smooth"),
    ("dielectrics", _made_of(lambda m: isinstance(m, Dielectric)), "nothing refracts"),
    (
        "rough dielectrics",
        _made_of(lambda m: kind_of(m) == Kind.ROUGH_DIELECTRIC),
        "no light is scattered through a surface",
    ),
    ("area lights", _area_lights, "no shape emits"),
    (
        "textured lights",
        lambda s: _listed(m for m in _shapes(s) if _glows_unevenly(m)),
        "all of a shape emits the same radiance",
    ),
    (
        "lights of two sides",
        lambda s: _listed(m for m in _shapes(s) if emits(m) and m.two_sided_emission),
        "light leaves fronts alone",
    ),
    ("point lights", lambda s: _count(len(s.points), "point light"), "none"),
    ("spot lights", lambda s: _count(len(s.spots), "spot light"), "none"),
    ("suns", lambda s: _count(len(s.suns), "sun"), "none"),
    ("environment", _environment, "black beyond the scene"),
    (
        "emitter hits",
        _chance,
        "no ray can meet a light: none is drawn at the last vertex, no MIS weight",
    ),
    (
        "sample points that are not Lambertian",
        _glossy_samples,
        "samples send the same radiance into all directions, as reuse takes them to",
    ),
    (
        "occlusion between points",
        _occlusion,
        "convex: all points see each other unless a horizon parts them",
    ),
)
