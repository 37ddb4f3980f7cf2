"""A scene under more light, or less."""

from dataclasses import replace

from reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    LatLongEnvironment,
    PointLight,
)
from reference.scene.scene import Scene
from reference.scene.textures import Color


def brightened(scene: Scene, factor: float) -> Scene:
    """The same scene with all its lights scaled.

    Parameters
    ----------
    scene : Scene
        Any.
    factor : float
        On all that emits, positive; a power of two scales each picture by itself and
        changes nothing else, to the last bit.

    Returns
    -------
    Scene
        Shapes that do not emit are the same objects.
    """

    def scaled(color: Color) -> Color:
        r, g, b = color
        return factor * r, factor * g, factor * b

    def point(light: PointLight) -> PointLight:
        return replace(light, intensity=scaled(light.intensity))

    def sun(light: DirectionalLight) -> DirectionalLight:
        return replace(light, irradiance=scaled(light.irradiance))

    sky = scene.environment
    if isinstance(sky, ConstantEnvironment):
        sky = replace(sky, radiance=scaled(sky.radiance))
    elif isinstance(sky, LatLongEnvironment):
        sky = replace(sky, pixels=factor * sky.pixels)
    return replace(
        scene,
        meshes=tuple(
            replace(m, emission=scaled(m.emission)) if any(m.emission) else m
            for m in scene.meshes
        ),
        spheres=tuple(
            replace(s, emission=scaled(s.emission)) if any(s.emission) else s
            for s in scene.spheres
        ),
        points=tuple(point(p) for p in scene.points),
        suns=tuple(sun(s) for s in scene.suns),
        environment=sky,
    )
