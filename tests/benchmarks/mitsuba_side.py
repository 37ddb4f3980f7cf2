"""Mitsuba's side of the comparison: our scenes in its words, and indirect light alone.

    python -m tests.benchmarks.mitsuba_side SCENE SIZE BOUNCES SAMPLES

renders so many samples in a process of its own, and prints how many seconds of that
went into translating the scene, which a user of Mitsuba would have in a file.  It needs
Mitsuba's LLVM variant, and with it a shared library of LLVM (16 or newer; the variable
DRJIT_LIBLLVM_PATH names it where there are several).
"""

import sys
import tempfile
import time
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

LAUNCH = 16
"""Samples a pixel in a launch, at most."""


def opened(name: str, size: int, bounces: int) -> "Indirect":
    """A scene, ready to be rendered."""
    mi.set_variant("llvm_ad_rgb")
    if name == "veach-ajar":
        from tests.benchmarks.our_side import real_scene

        return Indirect(from_file(real_scene(), size, size), bounces)
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        parts = translated(name, size, Path(folder))
        translation = time.perf_counter() - start
        return Indirect(mi.load_dict(parts), bounces, translation)


def translated(name: str, size: int, folder: Path) -> dict:
    """A scene of triangles, Lambertian surfaces, area lights and suns."""
    from tests.benchmarks.our_side import scene_of

    scene = scene_of(name, size)
    camera = scene.camera
    parts = {
        "type": "scene",
        "sensor": {
            "type": "perspective",
            "fov": camera.fov,
            "fov_axis": camera.fov_axis,
            "to_world": mi.ScalarTransform4f().look_at(
                list(camera.position), list(camera.target), list(camera.up)
            ),
            "film": {
                "type": "hdrfilm",
                "width": camera.width,
                "height": camera.height,
            },
        },
    }
    for number, sun in enumerate(scene.suns):
        parts[f"sun{number}"] = {
            "type": "directional",
            "direction": list(sun.direction),
            "irradiance": {"type": "rgb", "value": list(sun.irradiance)},
        }
    for number, mesh in enumerate(scene.meshes):
        parts[f"mesh{number}"] = _shape(mesh, folder / f"{number}.ply")
    return parts


def _shape(mesh, path):
    from restir_gi.reference.scene.geometry import world_corners
    from restir_gi.reference.scene.materials.kinds import Lambertian

    assert isinstance(mesh.material, Lambertian), mesh.name
    corners = world_corners(mesh)
    built = mi.Mesh(mesh.name, 3 * len(corners), len(corners))
    values = mi.traverse(built)
    values["vertex_positions"] = mi.Float(corners.ravel())
    values["faces"] = mi.UInt32(np.arange(3 * len(corners)))
    values.update()
    built.write_ply(str(path))
    diffuse = {
        "type": "diffuse",
        "reflectance": {"type": "rgb", "value": list(mesh.material.reflectance)},
    }
    shape = {
        "type": "ply",
        "filename": str(path),
        "face_normals": True,
        "bsdf": {"type": "twosided", "nested": diffuse},
    }
    if any(mesh.emission):
        radiance = {"type": "rgb", "value": list(mesh.emission)}
        shape["emitter"] = {"type": "area", "radiance": radiance}
    return shape


def from_file(path: Path, width: int, height: int):
    scene = mi.load_file(str(path))
    film = mi.traverse(scene.sensors()[0])
    film["film.size"] = [width, height]
    film["film.crop_size"] = [width, height]
    film.update()
    return scene


class Indirect:
    """Paths from pixel centres whose light has bounced at least once on its way.

    The visible point's lobe is sampled, and what comes along that ray is Mitsuba's own
    path integrator's, without the light that the ray meets at once: that is direct.
    """

    def __init__(self, scene, bounces: int, translation: float = 0.0) -> None:
        self.translation = translation
        self.scene, self.sensor = scene, scene.sensors()[0]
        options = {"max_depth": bounces + 1, "rr_depth": 1000, "hide_emitters": True}
        self.inner = mi.load_dict({"type": "path", **options})
        self.whole = mi.load_dict({"type": "path", **options, "max_depth": bounces + 2})
        size = self.sensor.film().crop_size()
        self.width, self.height = int(size[0]), int(size[1])

    def estimate(self, samples: int, seed: int) -> np.ndarray:
        """(N, 3): mean of so many samples a pixel, a power of two."""
        pixels = self.width * self.height
        number = dr.arange(mi.UInt32, pixels * samples) // samples
        place = mi.Point2f(
            (mi.Float(number % self.width) + 0.5) / self.width,
            (mi.Float(number // self.width) + 0.5) / self.height,
        )
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, pixels * samples)
        ray, _ = self.sensor.sample_ray(0.0, 0.5, place, mi.Point2f(0.5))
        seen = self.scene.ray_intersect(ray)
        there = seen.is_valid()
        lobe, weight = seen.bsdf(ray).sample(
            mi.BSDFContext(), seen, sampler.next_1d(), sampler.next_2d(), there
        )
        onward = mi.RayDifferential3f(seen.spawn_ray(seen.to_world(lobe.wo)))
        light, _, _ = self.inner.sample(self.scene, sampler, onward, None, there)
        color = dr.select(there, weight * light, 0)
        # Each channel is summed by itself, and would trace all paths for itself.
        dr.eval(color)
        mean = dr.block_sum(color, samples) / samples
        dr.eval(mean)
        dr.sync_thread()
        return np.array(mean).T

    def render(self, samples: int, seed: int) -> None:
        """Mitsuba's own picture of all light, to see that it is as fast."""
        picture = mi.render(self.scene, integrator=self.whole, seed=seed, spp=samples)
        dr.eval(picture)
        dr.sync_thread()


def passes_over_all_paths(name: str, size: int, samples: int) -> int:
    """Kernels that one estimate starts for each of its paths: one traces them."""
    indirect = opened(name, size, 1)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        indirect.estimate(samples, 0)
        kernels = dr.kernel_history([dr.KernelType.JIT])
    return sum(kernel["size"] == size * size * samples for kernel in kernels)


if __name__ == "__main__":
    name, (size, bounces, samples) = sys.argv[1], map(int, sys.argv[2:])
    indirect = opened(name, size, bounces)
    for done in range(0, samples, LAUNCH):
        indirect.estimate(min(LAUNCH, samples - done), done)
    print(indirect.translation)
