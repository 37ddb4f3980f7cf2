"""A scene made ready for rays: primitives, accelerator and lights."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.emitters import Emitters, build_emitters
from restir_gi.reference.scene.geometry import Geometry, build_geometry
from restir_gi.reference.scene.materials.parameters import MaterialTable
from restir_gi.reference.scene.plan import Plan, plan_of
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.transport.caster import RayCaster

Planner = Callable[[Scene], Plan]


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A scene made ready for rays.

    Attributes
    ----------
    scene : Scene; what it was made of
    geometry : Geometry; primitives and what they are of
    materials : MaterialTable; its materials, which kernels look up by row
    caster : RayCaster; traces rays, and counts them
    emitters : Emitters or None; lights; ``None`` where nothing emits
    plan : Plan; what is run for the scene
    planner : callable; scene to plan, for the next frame
    """

    scene: Scene
    geometry: Geometry
    materials: MaterialTable
    caster: RayCaster
    emitters: Emitters | None
    plan: Plan
    planner: Planner

    @property
    def camera(self) -> Camera:
        """The eye."""
        return self.scene.camera

    @property
    def seeks_lights(self) -> bool:
        """Whether the last ray of a path looks for a light."""
        return self.plan.chance and self.emitters is not None


def build_world(
    scene: Scene, before: World | None = None, planner: Planner = plan_of
) -> World:
    """Make a scene ready for rays, with a camera of the size that the scene asks for.

    Parameters
    ----------
    scene : Scene; validated by :func:`restir_gi.reference.scene.validation.validate`
    before : World, optional
        Of another frame of the same animation, in whose counter rays are counted on.
    planner : callable
        Scene to plan; by default what the scene requires is run, and nothing else.
    """
    geometry = build_geometry(scene)
    plan = planner(scene)
    caster = RayCaster(geometry, before.caster if before else None, plan.occlusion)
    return World(
        scene=scene,
        geometry=geometry,
        materials=geometry.materials,
        caster=caster,
        emitters=build_emitters(scene, geometry),
        plan=plan,
        planner=planner,
    )


def next_world(before: World, scene: Scene) -> World:
    """The world of the next frame; what has not changed is not made again.

    Returns ``before`` itself where the scene is the same object; a world of the same
    geometry and lights where only the camera differs.  Rays are counted on in one
    counter.

    Parameters
    ----------
    scene : Scene; of another frame of the same animation
    """
    if scene is before.scene:
        return before
    if same_but_for_the_camera(before.scene, scene):
        return replace(before, scene=scene)
    return build_world(scene, before, before.planner)


def same_but_for_the_camera(a: Scene, b: Scene) -> bool:
    """Whether two scenes hold the very same shapes and lights, by identity.

    What an animation does not change stays the same object.

    Parameters
    ----------
    a, b : Scene; frames of one animation
    """
    ours = (*a.meshes, *a.spheres, *a.lamps, *a.suns, a.environment)
    theirs = (*b.meshes, *b.spheres, *b.lamps, *b.suns, b.environment)
    pairs = zip(ours, theirs, strict=False)
    return len(ours) == len(theirs) and all(x is y for x, y in pairs)
