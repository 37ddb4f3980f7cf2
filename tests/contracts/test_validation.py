"""What the validation refuses, in one line each, and what it must let pass."""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.registry import CATALOGUE
from restir_gi.reference.scene.catalogue.rooms import pose
from restir_gi.reference.scene.checks.shapes import has_area
from restir_gi.reference.scene.checks.shells import closed_shells
from restir_gi.reference.scene.checks.space import crossings, distance_to_triangles
from restir_gi.reference.scene.geometry import build_geometry, world_corners
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    LatLongEnvironment,
    PointLight,
    SpotLight,
)
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
)
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere, box, quad
from restir_gi.reference.scene.textures import Bitmap, Checker
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError

GREY = Lambertian((0.5, 0.5, 0.5))
NAN, INF = float("nan"), float("inf")


def plain():
    """A floor, a ball, a lamp, a sun, a sky and a map of one, all in order."""
    return Scene(
        name="plain",
        camera=Camera(position=(0, 1, 3), target=(0, 0, 0)),
        meshes=(
            quad("floor", (-1, 0, 1), (2, 0, 0), (0, 0, -2), GREY),
            quad("lamp", (0, 2, 0), (0.1, 0, 0), (0, 0, 0.1), GREY, (1.0, 1.0, 1.0)),
        ),
        spheres=(Sphere(name="ball", center=(0, 0.5, 0), radius=0.3, material=GREY),),
        points=(PointLight((0, 3, 0), (1.0, 1.0, 1.0)),),
        spots=(SpotLight((0, 3, 0), (0, -1, 0), (1.0, 1.0, 1.0), 30.0, 30.0),),
        suns=(DirectionalLight((0, -1, 0), (1.0, 1.0, 1.0)),),
        environment=ConstantEnvironment((0.1, 0.1, 0.1)),
    )


def floor(**changes):
    """The plain scene with another floor."""
    scene = plain()
    return replace(scene, meshes=(replace(scene.meshes[0], **changes), scene.meshes[1]))


def floor_of(material):
    return floor(material=material)


def ball(**changes):
    scene = plain()
    return replace(scene, spheres=(replace(scene.spheres[0], **changes),))


def camera(**changes):
    scene = plain()
    return replace(scene, camera=replace(scene.camera, **changes))


def lights(**changes):
    return replace(plain(), **changes)


def spot(**changes):
    light = SpotLight((0, 2, 0), (0, -1, 0), (1.0, 1, 1), cutoff=30.0, beam=20.0)
    return lights(spots=(replace(light, **changes),))


def sky_map(pixels, **changes):
    return lights(environment=LatLongEnvironment(np.array(pixels), **changes))


def vertices(row, value):
    changed = plain().meshes[0].vertices.copy()
    changed[row] = value
    return changed


def moved(row, column, value):
    matrix = np.eye(4)
    matrix[row, column] = value
    return matrix


FLAT_POSE = np.diag([1.0, 1.0, 0.0, 1.0])
FACES = np.array([[0, 1, 2], [0, 2, 3]])
WHITE_PIXELS = np.ones((2, 2, 3))
OVER = WHITE_PIXELS * [1.0, 1.0, 1.5]

BAD = {
    # Shapes.
    "no geometry": (replace(plain(), meshes=(), spheres=()), "geometry"),
    "vertex NaN": (floor(vertices=vertices(2, (NAN, 0, 1))), '"floor"', "vertex 2"),
    "vertex infinite": (floor(vertices=vertices(3, (0, INF, 0))), "vertex 3", "inf"),
    "vertex too far": (floor(vertices=vertices(1, 1e60)), '"floor"', "vertex 1"),
    "vertices in 2D": (floor(vertices=np.zeros((4, 2))), '"floor"', "4x2"),
    "normal NaN": (
        floor(normals=vertices(1, (0, NAN, 0))),
        '"floor"',
        "normal 1",
        "finite",
    ),
    "too few normals": (floor(normals=np.ones((3, 3))), '"floor"', "3 normals"),
    "uv infinite": (floor(uv=np.full((4, 2), INF)), '"floor"', "texture coordinate 0"),
    "uv too far": (floor(uv=np.full((4, 2), -1e60)), '"floor"', "coordinate", "1e+50"),
    "face too high": (floor(faces=FACES + 1), '"floor"', "face 1", "0 to 3"),
    "face negative": (floor(faces=FACES - 1), '"floor"', "face 0"),
    "faces of floats": (floor(faces=FACES * 1.0), '"floor"', "integers"),
    "faces of four": (floor(faces=np.zeros((1, 4), int)), '"floor"', "(F, 3)"),
    "pose NaN": (floor(pose=moved(0, 3, NAN)), '"floor"', "pose", "nan"),
    "pose infinite": (floor(pose=moved(1, 1, INF)), '"floor"', "pose"),
    "pose 3x3": (floor(pose=np.eye(3)), '"floor"', "(4, 4)"),
    "pose projective": (floor(pose=moved(3, 0, 0.1)), '"floor"', "last row"),
    "pose flat": (floor(pose=FLAT_POSE), '"floor"', "flattens"),
    "pose far": (floor(pose=moved(0, 0, 1e55)), '"floor"', "vertex 0", "1e+50"),
    "emission NaN": (floor(emission=(NAN, 0, 0)), '"floor"', "emission", "nan"),
    "emission infinite": (floor(emission=(0, INF, 0)), '"floor"', "emission"),
    "emission negative": (floor(emission=(0, 0, -1.0)), '"floor"', "emission"),
    "radius zero": (ball(radius=0.0), '"ball"', "radius is 0"),
    "radius negative": (ball(radius=-2.0), '"ball"', "radius is -2"),
    "radius NaN": (ball(radius=NAN), '"ball"', "radius"),
    "center NaN": (ball(center=(0, NAN, 0)), '"ball"', "center"),
    "sphere emission": (ball(emission=(-1.0, 0, 0)), '"ball"', "emission"),
    "too small": (
        replace(
            plain(), meshes=(), spheres=(replace(plain().spheres[0], radius=1e-60),)
        ),
        "wide",
    ),
    "too remote": (
        replace(
            plain(), meshes=(), spheres=(replace(plain().spheres[0], radius=1e-10),)
        ),
        "origin",
        "float64",
    ),
    # Materials.
    "albedo negative": (floor_of(Lambertian((0.5, -0.1, 0))), '"floor"', "reflectance"),
    "albedo above 1": (floor_of(Lambertian((0.5, 1.1, 0))), '"floor"', "0 to 1"),
    "albedo NaN": (floor_of(Lambertian((NAN, 0, 0))), '"floor"', "reflectance"),
    "albedo on a sphere": (
        ball(material=Lambertian((2.0, 0, 0))),
        '"ball"',
        "(2, 0, 0)",
    ),
    "albedo of two": (floor_of(Lambertian((0.5, 0.5))), '"floor"', "2 numbers"),
    "bitmap above 1": (floor_of(Lambertian(Bitmap(OVER))), '"floor"', "bitmap", "1.5"),
    "bitmap NaN": (floor_of(Lambertian(Bitmap(WHITE_PIXELS * NAN))), "bitmap", "nan"),
    "bitmap empty": (
        floor_of(Lambertian(Bitmap(np.ones((0, 2, 3))))),
        "bitmap",
        "0x2x3",
    ),
    "bitmap grey": (floor_of(Lambertian(Bitmap(np.ones((2, 2))))), "bitmap", "2x2"),
    "bitmap scale": (
        floor_of(Lambertian(Bitmap(WHITE_PIXELS, scale=(NAN, 1.0)))),
        "scale",
    ),
    "checker negative": (
        floor_of(Lambertian(Checker((1.0, 1, 1), (0, 0, -1.0)))),
        "checker",
    ),
    "checker scale": (
        floor_of(Lambertian(Checker((1.0, 1, 1), (0, 0, 0), (INF, 1)))),
        "scale",
    ),
    "alpha negative": (
        floor_of(Conductor((1.0, 1, 1), -0.1)),
        "alpha is -0.1",
        "0.001 to 1",
    ),
    "alpha tiny": (floor_of(Conductor((1.0, 1, 1), 1e-4)), "alpha is 0.0001", "smooth"),
    "alpha above 1": (floor_of(Coated((1.0, 1, 1), 1.5)), "alpha is 1.5"),
    "alpha NaN": (floor_of(Coated((1.0, 1, 1), NAN)), "alpha"),
    "eta zero": (
        floor_of(Conductor((1.0, 1, 1), 0.1, (0.0, 1, 1), (1.0, 1, 1))),
        "eta",
    ),
    "k negative": (floor_of(Conductor((1.0, 1, 1), 0.1, (1, 1, 1), (-1.0, 1, 1))), "k"),
    "k alone": (
        floor_of(Conductor((1.0, 1, 1), 0.1, None, (1.0, 1, 1))),
        "without eta",
    ),
    "coat ior 0": (floor_of(Coated((1.0, 1, 1), 0.1, 0.0)), "ior is 0"),
    "coat ior below 1": (floor_of(Coated((1.0, 1, 1), 0.1, 0.9)), "ior is 0.9"),
    "coat specular": (
        floor_of(Coated((1.0, 1, 1), 0.1, specular=(2, 1, 1))),
        "specular",
    ),
    "glass ior 0": (floor_of(Dielectric(0.0)), "ior is 0"),
    "glass ior negative": (floor_of(Dielectric(-1.5)), "ior is -1.5"),
    "glass ior NaN": (floor_of(Dielectric(NAN)), "ior"),
    # Lights.
    "intensity negative": (
        lights(points=(PointLight((0, 0, 0), (-1.0, 0, 0)),)),
        "point light 0",
        "intensity",
    ),
    "emission beyond all measure": (
        floor(emission=(1e308, 1.0, 1.0)),
        'mesh "floor"',
        "emission",
        "0 to 1e+30",
    ),
    "sky beyond all measure": (sky_map(1e101 * WHITE_PIXELS), "radiance", "1e+30"),
    "texture of radiance negative": (
        floor(emission=Bitmap(-WHITE_PIXELS)),
        'mesh "floor"',
        "emission in the bitmap",
        "-1",
    ),
    "checker of radiance NaN": (
        ball(emission=Checker((NAN, 0, 0), (1.0, 1, 1))),
        'sphere "ball"',
        "emission of the checker",
    ),
    "texture of radiance in one channel": (
        floor(emission=Bitmap(np.ones((2, 2)))),
        "bitmap of its emission",
        "2x2",
    ),
    "spot without direction": (spot(direction=(0, 0, 0)), "spot light 0", "length 1"),
    "spot negative": (spot(intensity=(0, -1, 0)), "spot light 0", "intensity"),
    "spot far out": (spot(position=(0, 1e60, 0)), "spot light 0", "position"),
    "spot too narrow": (spot(cutoff=0.001, beam=0.0), "cutoff", "0.01 to 180"),
    "spot beyond the sphere": (spot(cutoff=181.0), "cutoff", "0.01 to 180"),
    "spot of a wide beam": (spot(beam=31.0), "beam is 31", "at most cutoff, 30"),
    "spot of no falloff": (spot(falloff="cubic"), "falloff", "linear or smooth"),
    "lamp NaN": (
        lights(points=(*plain().points, PointLight((0, NAN, 0), (1.0, 0, 0)))),
        "point light 1",
        "position",
    ),
    "sun without direction": (
        lights(suns=(DirectionalLight((0, 0, 0), (1.0, 1, 1)),)),
        "sun 0",
        "direction",
        "length 1",
    ),
    "sun too long": (
        lights(suns=(DirectionalLight((0, 2, 0), (1.0, 1, 1)),)),
        "2 long",
    ),
    "sun negative": (
        lights(suns=(DirectionalLight((0, 1, 0), (0, 0, -1.0)),)),
        "irradiance",
    ),
    "sky NaN": (lights(environment=ConstantEnvironment((NAN, 0, 0))), "environment"),
    "sky negative": (sky_map(-WHITE_PIXELS), "environment", "radiance", "-1"),
    "sky of one channel": (sky_map(np.ones((2, 2))), "environment", "2x2"),
    "sky skewed": (sky_map(WHITE_PIXELS, to_world=np.eye(3) * 2), "rotation"),
    "dark": (
        Scene(name="dark", camera=plain().camera, meshes=plain().meshes[:1]),
        "dark",
        "emits",
    ),
    "black sun": (
        Scene(
            name="black",
            camera=plain().camera,
            meshes=plain().meshes[:1],
            suns=(DirectionalLight((0, -1, 0), (0.0, 0, 0)),),
            environment=ConstantEnvironment((0.0, 0, 0)),
        ),
        "emits",
    ),
    # Camera.
    "camera NaN": (camera(position=(NAN, 1, 3)), "camera", "position"),
    "camera on its target": (camera(target=(0, 1, 3)), "camera", "target", "(0, 1, 3)"),
    "up along the view": (camera(up=(0, 1, 3)), "camera", "up is parallel"),
    "up against the view": (camera(up=(0, -2, -6)), "camera", "up is parallel"),
    "up zero": (camera(up=(0, 0, 0)), "camera", "up is (0, 0, 0)"),
    "fov 0": (camera(fov=0.0), "camera", "fov is 0", "180"),
    "fov 180": (camera(fov=180.0), "camera", "fov is 180"),
    "fov NaN": (camera(fov=NAN), "camera", "fov"),
    "fov of no axis": (camera(fov_axis="z"), "camera", "'z'", "diagonal"),
    "width 0": (camera(width=0), "camera", "0x256", "1x1"),
    "height negative": (camera(height=-4), "camera", "256x-4"),
    "absurd size": (camera(width=10**6, height=10**6), "camera", "268435456"),
    "half a pixel": (camera(width=0.5), "camera", "whole"),
    "camera on the floor": (
        camera(position=(0.3, 0.0, 0.2)),
        "camera",
        "touches",
        'mesh "floor"',
    ),
    "camera on an edge": (camera(position=(1.0, 0.0, 0.2)), "touches", '"floor"'),
    "camera on a corner": (camera(position=(1.0, 0.0, 1.0)), "touches", '"floor"'),
    "camera on the ball": (camera(position=(0, 0.5, 0.3)), "touches", 'sphere "ball"'),
    "camera in the ball": (camera(position=(0, 0.5, 0.1)), "inside", 'sphere "ball"'),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused_in_one_line(name):
    scene, *words = BAD[name]
    with pytest.raises(UsageError) as error:
        validate(scene)
    message = str(error.value)
    assert message.startswith(scene.name)
    assert len(message.splitlines()) == 1
    assert [word for word in words if word not in message] == []
    # What is wrong; what would be right.
    assert "; " in message


def test_control_the_plain_scene_is_let_pass_as_it_is():
    scene = plain()
    assert validate(scene) is scene


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_catalogue_is_let_pass_as_it_is(name):
    scene = CATALOGUE[name].build()
    assert validate(scene) is scene


@pytest.mark.parametrize(
    "scene",
    [
        floor_of(Conductor((1.0, 1.0, 1.0), 0.0)),
        floor_of(Conductor((1.0, 1.0, 1.0), 1e-3)),
        floor_of(Conductor((1.0, 1.0, 1.0), 1.0, (0.2, 0.9, 1.1), (3.9, 2.4, 2.1))),
        floor_of(Coated((0.0, 0.0, 0.0), 0.0)),
        floor_of(Dielectric(0.75)),
        floor_of(Lambertian(Bitmap(WHITE_PIXELS))),
        ball(material=Dielectric(1.5)),
        camera(width=1, height=1),
        camera(fov=179.9),
        camera(up=(0.0, 0.0, -1e-30)),
        camera(position=(1e9, 1e9, 3e9)),
        sky_map(WHITE_PIXELS),
        floor(pose=np.diag([1.0, -1.0, 1.0, 1.0])),
        floor(normals=vertices(0, (0.0, 0.0, 0.0))),
    ],
)
def test_the_ends_of_what_is_meant_are_let_pass(scene):
    validate(scene)


def test_reality_passes_at_every_scale_and_offset():
    """Scales 1e-3 to 1e3, moved by up to a thousand metres."""
    room = CATALOGUE["cornell-box"].build()
    for scale in (1e-3, 1.0, 1e3):
        for offset in (0.0, 1e3):
            move = np.diag([scale, scale, scale, 1.0])
            move[:3, 3] = offset
            eye = replace(
                room.camera,
                position=tuple(scale * np.array(room.camera.position) + offset),
                target=tuple(scale * np.array(room.camera.target) + offset),
            )
            meshes = tuple(replace(m, pose=move @ m.pose) for m in room.meshes)
            assert validate(replace(room, meshes=meshes, camera=eye)).notes == ()


# ---------------------------------------------------------------- flat triangles


def with_flat_faces():
    """Floor of four triangles: one a point, one a line."""
    faces = np.array([[0, 1, 2], [1, 1, 1], [0, 2, 3], [0, 2, 0]])
    return floor(faces=faces)


def test_triangles_without_area_are_dropped_counted_and_named():
    scene = validate(with_flat_faces())
    assert scene.notes == (
        'Mesh "floor": 2 of 4 triangles have no area and are left out.',
    )
    assert np.array_equal(scene.meshes[0].faces, [[0, 1, 2], [0, 2, 3]])
    assert scene.meshes[1].name == "lamp"
    geometry = build_geometry(scene)
    assert geometry.triangles == 4
    assert (geometry.area > 0).all()


def test_a_mesh_of_flat_triangles_goes_and_a_scene_of_such_has_no_geometry():
    flat = replace(plain().meshes[0], faces=np.array([[0, 0, 1]]), name="line")
    scene = replace(plain(), meshes=(*plain().meshes, flat))
    assert [m.name for m in validate(scene).meshes] == ["floor", "lamp"]
    assert 'Mesh "line": 1 of 1' in validate(scene).notes[0]
    with pytest.raises(UsageError, match="no geometry"):
        validate(replace(scene, meshes=(flat,), spheres=()))


def test_notes_of_the_loader_stay_first():
    scene = replace(with_flat_faces(), notes=("Said before.",))
    assert validate(scene).notes[0] == "Said before."
    assert len(validate(scene).notes) == 2


@pytest.mark.parametrize("scale", [1e-40, 1e-3, 1.0, 1e3, 1e40])
def test_collinear_corners_have_no_area_even_where_rounding_gives_them_one(scale):
    """0.1, 0.3 and 0.7 of one vector: their cross product is rounding."""
    direction = np.array([0.37, 0.91, -0.53]) * scale
    line = np.stack([t * direction for t in (0.1, 0.3, 0.7)])
    sliver = line + np.array([[0.0], [0.0], [1e-9]]) * np.array([1.0, 0, 0]) * scale
    assert has_area(np.stack([line, sliver])).tolist() == [False, True]
    assert np.cross(line[1] - line[0], line[2] - line[0]).any() or scale != 1.0


# ---------------------------------------------------------------- shut up in the dark


def room(material=GREY, inward=True, extra=(), lamps=(), eye=(0.1, 0.2, 0.3), **more):
    """A closed box about the origin, seen from inside, the sun outside."""
    return Scene(
        name="room",
        camera=Camera(position=eye, target=(0.4, 0.1, 0.0)),
        meshes=(box("box", (2, 2, 2), pose(10, (0, 0, 0)), material, inward), *extra),
        suns=(DirectionalLight((0, -1, 0), (1.0, 1.0, 1.0)),),
        points=lamps,
        **more,
    )


def glowing(mesh):
    return replace(mesh, emission=(1.0, 1.0, 1.0))


def lamp(corner, u=(0.1, 0, 0), v=(0, 0, 0.1)):
    return quad("lamp", corner, u, v, GREY, (1.0, 1.0, 1.0))


BALL = Sphere(name="ball", center=(0, 0, 0), radius=1.0, material=GREY)
BULB = Sphere(
    name="bulb", center=(0.3, 0, 0), radius=0.1, material=GREY, emission=(1.0, 1, 1)
)
INNER = box("inner", (0.5, 0.5, 0.5), pose(33, (0.1, 0.2, 0.3)), GREY)
SUNNY = ConstantEnvironment((1.0, 1.0, 1.0))
SHUT = {
    "a closed box": room(),
    "a closed box, seen from the corner": room(eye=(0.93, 0.93, 0.65)),
    "fronts outward": room(inward=False),
    "a one-sided material": room(material=Lambertian((0.5,) * 3, two_sided=False)),
    "the box glows outward": replace(
        room(inward=False), meshes=(glowing(room(inward=False).meshes[0]),)
    ),
    "the lamp hangs outside": room(extra=(lamp((3, 0, 0)),)),
    "the lamp is near the outside": room(extra=(lamp((-1.0, 0.5, 1.05)),)),
    "the point is outside": room(lamps=(PointLight((0, 1.5, 0), (1.0, 1, 1)),)),
    "a sky outside": room(environment=SUNNY),
    "in a block in a lit room": room(extra=(INNER, lamp((0.5, 0.9, 0.5)))),
    "two boxes nested": room(extra=(box("big", (5, 5, 5), np.eye(4), GREY),)),
    "a ball": replace(room(), meshes=(), spheres=(BALL,)),
    "a ball in a lit room": replace(
        room(),
        meshes=(lamp((2, 2, 2)),),
        spheres=(BALL, replace(BULB, center=(3.0, 0, 0))),
    ),
    "a ball inside a bulb": replace(
        room(), meshes=(), spheres=(BALL, replace(BULB, radius=9.0))
    ),
}


def merged(first, second):
    """Two meshes as one; the material of the first."""
    a, b = world_corners(first), world_corners(second)
    corners = np.concatenate([a, b]).reshape(-1, 3)
    faces = np.arange(len(corners)).reshape(-1, 3)
    return Mesh(name="both", vertices=corners, faces=faces, material=first.material)


SHUT["a block and its room are one mesh"] = replace(
    room(),
    meshes=(merged(room().meshes[0], INNER), lamp((0.5, 0.9, 0.5))),
)
SHUT["vertices not shared"] = replace(
    room(),
    meshes=(merged(room().meshes[0], box("far", (1, 1, 1), pose(0, (9, 0, 0)), GREY)),),
)


@pytest.mark.parametrize("name", SHUT)
def test_a_camera_shut_up_in_the_dark_is_refused(name):
    with pytest.raises(UsageError, match="camera: it is inside"):
        validate(SHUT[name])


OPEN_BOX = replace(room().meshes[0], faces=room().meshes[0].faces[:-1])
LIT = {
    "a lamp inside": room(extra=(lamp((0.2, 0.9, 0.2)),)),
    "a lamp through the wall": room(extra=(lamp((0.5, 0.5, 0), (2, 0, 0)),)),
    "a wide lamp, cut by the box": room(
        extra=(lamp((-9, 0, -9), (18, 0, 0), (0, 0, 18)),)
    ),
    "a lamp on the wall's inside": room(
        extra=(
            quad("lamp", (-0.1, 0.999, 0), (0, 0, 0.1), (0.1, 0, 0), GREY, (1, 1, 1)),
        )
    ),
    "a point inside": room(lamps=(PointLight((0, 0.9, 0), (1.0, 1, 1)),)),
    "the box glows inward": replace(room(), meshes=(glowing(room().meshes[0]),)),
    "a bulb inside": room(spheres=(BULB,)),
    "a bulb through the wall": room(spheres=(replace(BULB, center=(1.0, 0, 0)),)),
    "glass": room(material=Dielectric(1.5)),
    "a glass ball": replace(
        room(), meshes=(), spheres=(replace(BALL, material=Dielectric(1.5)),)
    ),
    "a hole": replace(room(), meshes=(OPEN_BOX,)),
    "outside": room(eye=(3.0, 0, 0)),
    "between two walls": room(
        eye=(1.8, 0, 0), extra=(box("big", (5, 5, 5), np.eye(4), GREY), lamp((0, 2, 0)))
    ),
    "a glowing ball": replace(
        room(),
        meshes=(),
        spheres=(replace(BALL, emission=(1.0, 1, 1), inward=True),),
    ),
    "a ball with a lamp": replace(room(), meshes=(lamp((0.5, 0, 0)),), spheres=(BALL,)),
    "a ball with a bulb": replace(room(), meshes=(), spheres=(BALL, BULB)),
}


@pytest.mark.parametrize("name", LIT)
def test_a_camera_that_may_see_light_is_let_pass(name):
    validate(LIT[name])


def test_open_and_closed_parts_of_a_mesh_are_told_apart():
    """Two boxes, a box without a triangle, and a loose quad: two are closed."""
    whole = merged(INNER, room().meshes[0])
    broken = merged(OPEN_BOX, quad("loose", (5, 5, 5), (1, 0, 0), (0, 1, 0), GREY))
    mesh = merged(whole, broken)
    shells = list(closed_shells(mesh.faces, mesh.vertices, world_corners(mesh)))
    # The broken box shares its corners with the whole one, and opens it.
    assert [len(shell.faces) for shell in shells] == [12]
    shells = list(closed_shells(whole.faces, whole.vertices, world_corners(whole)))
    assert sorted((len(s.faces), s.outward) for s in shells) == [
        (12, False),
        (12, True),
    ]


def test_distances_are_those_of_a_dense_sampling():
    """The nearest of 20,100 points of a triangle is at most a step further than it."""
    rng = np.random.default_rng(1)
    corners = rng.normal(size=(30, 3, 3))
    i, j = np.triu_indices(201)
    u, v = i / 200, (j - i) / 200
    points = (
        corners[:, :1] * (1 - u - v)[None, :, None]
        + corners[:, 1:2] * u[None, :, None]
        + corners[:, 2:] * v[None, :, None]
    )
    step = np.linalg.norm(np.roll(corners, 1, 1) - corners, axis=2).max(axis=1) / 200
    for x in rng.normal(size=(20, 3)):
        sampled = np.linalg.norm(points - x, axis=2).min(axis=1)
        exact = distance_to_triangles(x, corners)
        assert (exact <= sampled + 1e-12).all()
        assert (exact >= sampled - step).all()


def test_crossings_are_those_of_the_equations():
    """Solve x + t d = a + u (b - a) + v (c - a) for each triangle."""
    rng = np.random.default_rng(2)
    corners = rng.normal(size=(2000, 3, 3))
    start, along = rng.normal(size=3), 3 * rng.normal(size=3)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    matrix = np.stack([b - a, c - a, np.broadcast_to(-along, a.shape)], axis=-1)
    u, v, t = np.linalg.solve(matrix, (start - a)[..., None])[..., 0].T
    expected = (u > 0) & (v > 0) & (u + v < 1) & (t > 0) & (t < 1)
    assert expected.sum() > 10
    assert np.array_equal(crossings(start, along, corners), expected)
