"""A scene under more light, or less."""

from dataclasses import replace

from restir_gi.reference.scene.lights import ConstantEnvironment, LatLongEnvironment
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import emits
from restir_gi.reference.scene.textures import Color, scaled, scaled_color


def brightened(scene: Scene, factor: float) -> Scene:
    """The same scene with all its lights scaled.

    Shapes that do not emit are the same objects.

    Parameters
    ----------
    factor : float
        On all that emits, positive; a power of two scales each picture by itself and
        changes nothing else, to the last bit.
    """

    def times(color: Color) -> Color:
        return scaled_color(color, factor)

    sky = scene.environment
    if isinstance(sky, ConstantEnvironment):
        sky = replace(sky, radiance=times(sky.radiance))
    elif isinstance(sky, LatLongEnvironment):
        sky = replace(sky, pixels=factor * sky.pixels)
    return replace(
        scene,
        meshes=tuple(
            replace(m, emission=scaled(m.emission, factor)) if emits(m) else m
            for m in scene.meshes
        ),
        spheres=tuple(
            replace(s, emission=scaled(s.emission, factor)) if emits(s) else s
            for s in scene.spheres
        ),
        points=tuple(replace(p, intensity=times(p.intensity)) for p in scene.points),
        spots=tuple(replace(s, intensity=times(s.intensity)) for s in scene.spots),
        suns=tuple(replace(s, irradiance=times(s.irradiance)) for s in scene.suns),
        environment=sky,
    )
