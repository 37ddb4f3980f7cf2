"""Two rooms, whose only light comes down a tall shaft in the one one does not see."""

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.rooms import BLACK, pose
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, quad
from restir_gi.reference.scene.shapes import box as block

WALL = Lambertian((0.78, 0.75, 0.7))
BRICK = Lambertian((0.55, 0.3, 0.2))
WOOD = Lambertian((0.5, 0.36, 0.24))
SOOT = Lambertian((0.02, 0.02, 0.02))

HALF, HEIGHT = 1.5, 2.6  # of both rooms, m
BACK = 5.1  # where the second room ends
WIDTH, TOP = 0.25, 9.0  # of the shaft, half, and where the lamp hangs
DOOR = (0.5, 1.3, 2.0)  # from, to, and height


def shaft() -> Scene:
    """A dark room beside one that a lamp at the top of a sooty shaft lights.

    Each 3 x 3.5 m and 2.6 m high.  Down the shaft, half a metre wide and 6.4 m long,
    light falls on a spot of the first room's floor; through a door some of it reaches
    the second, where the camera is.  Most of what it sees is two bounces from the spot,
    or more, and few directions lead there.
    """
    meshes = (
        *_slab("floor", 0.0),
        *_ceiling(),
        *_partition(),
        _wall("north wall", (-HALF, -HALF), (HALF, -HALF)),
        _wall("east wall", (HALF, -HALF), (HALF, BACK)),
        _wall("south wall", (HALF, BACK), (-HALF, BACK)),
        _wall("west wall", (-HALF, BACK), (-HALF, -HALF)),
        *_shaft(),
        block("table", (0.9, 0.05, 0.7), pose(10.0, (-0.8, 0.7, 3.2)), WOOD),
        block("chest", (0.6, 0.6, 0.6), pose(-15.0, (-0.9, 0.3, 4.3)), BRICK),
    )
    camera = Camera(position=(1.1, 1.5, 2.0), target=(-0.7, 0.9, 4.2), fov=65.0)
    return Scene(name="shaft", camera=camera, meshes=meshes)


def _slab(name: str, y: float) -> tuple[Mesh, ...]:
    up = quad(name, (-HALF, y, BACK), (2 * HALF, 0, 0), (0, 0, -BACK - HALF), WOOD)
    return (up,)


def _wall(name: str, start: tuple[float, float], end: tuple[float, float]) -> Mesh:
    (x, z), (x2, z2) = start, end
    return quad(name, (x, 0, z), (x2 - x, 0, z2 - z), (0, HEIGHT, 0), WALL)


def _ceiling() -> tuple[Mesh, ...]:
    """Round the shaft, and over the second room."""
    a, b = HALF, WIDTH
    strips = (
        ((-a, -a), (2 * a, a - b)),
        ((-a, b), (2 * a, BACK - b)),
        ((-a, -b), (a - b, 2 * b)),
        ((b, -b), (a - b, 2 * b)),
    )
    return tuple(
        quad(f"ceiling {k}", (x, HEIGHT, z), (w, 0, 0), (0, 0, d), WALL)
        for k, ((x, z), (w, d)) in enumerate(strips)
    )


def _partition() -> tuple[Mesh, ...]:
    """The wall between, 0.1 m thick, with a door."""
    left, right, top = DOOR
    parts = (
        ("beside the door", -HALF, left, 0.0, HEIGHT),
        ("behind the door", right, HALF, 0.0, HEIGHT),
        ("lintel", left, right, top, HEIGHT),
    )
    return tuple(
        block(
            name,
            (b - a, high - low, 0.1),
            pose(0.0, ((a + b) / 2, (low + high) / 2, HALF)),
            WALL,
        )
        for name, a, b, low, high in parts
    )


def _shaft() -> tuple[Mesh, ...]:
    b = WIDTH
    corners = ((-b, -b), (b, -b), (b, b), (-b, b))
    walls = tuple(
        quad(
            f"shaft {k}",
            (x, HEIGHT, z),
            (x2 - x, 0, z2 - z),
            (0, TOP - HEIGHT, 0),
            SOOT,
        )
        for k, ((x, z), (x2, z2)) in enumerate(
            zip(corners, corners[1:] + corners[:1], strict=True)
        )
    )
    lamp = quad(
        "lamp",
        (-b, TOP, -b),
        (2 * b, 0, 0),
        (0, 0, 2 * b),
        BLACK,
        emission=(4000.0, 3700.0, 3200.0),
    )
    return (*walls, lamp)
