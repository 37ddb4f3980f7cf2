"""Good files of every format, the least of their kind, and ways to spoil them."""

import base64
import json
import random
import re
import struct
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image as Pillow

from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.exr_parts import MAGIC
from restir_gi.reference.images.image import Image
from restir_gi.reference.oracle.golden import write_golden
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.parts import whole_contract

CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
FACES = [(0, 1, 2), (0, 2, 3)]
CAMERA = {"origin": [0.4, 0.5, 2], "target": [0.4, 0.5, 0], "fov_deg": 40}
NUMBERS = ("0", "-1", "1e308", "-1e308", "1e-320", "1e999", "nan", "inf", "9" * 308,
           "-0.0", "2147483648", "18446744073709551616", "0.1e", "--1", "")  # fmt: skip
TEXTS = ("", "\x1b[2J\x07", "a\nb", "\0", "x" * 300, "é\u202e\u2028", "../../etc",
         "/dev/zero", "/dev/null/x", "[/red]", "{}", "%s%n")  # fmt: skip


RUN = {
    "scene": "cornell-box", "method": "restir-gi-biased", "light": "indirect",
    "bounces": "1", "seed": "0", "frame": "0", "frames": "1", "spp": "1",
}  # fmt: skip
"""The header of a picture that can be made again."""


@dataclass(frozen=True)
class CorpusFile:
    """A good file, and those that it reads."""

    kind: str  # 'scene', 'picture', 'python' or 'golden'
    name: str
    beside: tuple[str, ...] = ()


def write_corpus(folder: Path, mitsuba: bool) -> list[CorpusFile]:
    """Write all good files, and say which they are."""
    folder.mkdir(parents=True)
    picture = BytesIO()
    Pillow.new("RGB", (2, 2), (200, 100, 50)).save(picture, "PNG")
    texts = {
        "wall.ply": _ply(),
        "scene.json": json.dumps(_scene()),
        "room.obj": _obj(),
        "room.mtl": "newmtl red\nKd 0.6 0.1 0.1\nmap_Kd tile.png\nNs 10\nillum 2\n"
        "newmtl lamp\nKe 4 4 4\n",
        "room.gltf": json.dumps(_gltf(embedded=True)),
        "room.xml": MITSUBA,
        "mine.py": "class Mine:\n    precision = 'float32'\nBACKEND = Mine()\n",
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    (folder / "tile.png").write_bytes(picture.getvalue())
    (folder / "room.glb").write_bytes(_glb())
    (folder / "binary.ply").write_bytes(_binary_ply())
    _write_pictures(folder)
    _write_golden(folder / "golden")
    entries = [
        CorpusFile("scene", "scene.json", ("wall.ply", "tile.png")),
        CorpusFile("scene", "room.obj", ("room.mtl", "tile.png")),
        CorpusFile("scene", "room.gltf"),
        CorpusFile("scene", "room.glb"),
        CorpusFile("scene", "wall.ply"),
        CorpusFile("scene", "binary.ply"),
        CorpusFile("picture", "ours.exr"),
        CorpusFile("picture", "restir.exr"),
        CorpusFile("picture", "blender.exr"),
        CorpusFile("python", "mine.py"),
        CorpusFile("golden", "golden"),
    ]
    if mitsuba:
        entries.insert(0, CorpusFile("scene", "room.xml", ("wall.ply", "tile.png")))
    return entries


def spoiled(contents: bytes, rng: random.Random) -> bytes:
    """Contents with one to four faults; of a picture often in what its header says."""
    if contents.startswith(MAGIC) and rng.random() < 0.5:
        return _with_words(rng)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        contents = rng.choice(FAULTS)(contents, rng)
    return contents


def _with_words(rng: random.Random) -> bytes:
    """A sound picture whose header says what cannot be."""
    words = dict(RUN)
    for _ in range(rng.choice((1, 1, 2))):
        key = rng.choice([*words, "settings.radius", "settings.temporal", "settings.x"])
        words[key] = rng.choice((*NUMBERS, *TEXTS, "true", "path", "door-ajar"))
        words[key] = words[key].replace("\0", "")  # no text of a header holds one
    if rng.random() < 0.2:
        del words[rng.choice(list(words))]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.exr"
        write_exr(path, Image(_reservoirs(), words))
        return path.read_bytes()


def _flip(contents: bytes, rng: random.Random) -> bytes:
    found = bytearray(contents)
    for _ in range(min(len(found), rng.choice((1, 4, 32)))):
        found[rng.randrange(len(found))] = rng.choice((0, 1, 127, 128, 255, 10, 34))
    return bytes(found)


def _cut(contents: bytes, rng: random.Random) -> bytes:
    return contents[: rng.randrange(len(contents) + 1)]


def _drop(contents: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(contents) + 1)
    return contents[:start] + contents[start + rng.choice((1, 8, 100)) :]


def _repeat(contents: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(contents) + 1)
    part = contents[start : start + rng.choice((1, 8, 100))]
    return contents[:start] + part * rng.choice((2, 50)) + contents[start:]


def _number(contents: bytes, rng: random.Random) -> bytes:
    return _replaced(rb"-?\d+(?:\.\d+)?", rng.choice(NUMBERS), contents, rng)


def _word(contents: bytes, rng: random.Random) -> bytes:
    return _replaced(rb"[A-Za-z_]{3,}", rng.choice(TEXTS), contents, rng)


def _moved_word(contents: bytes, rng: random.Random) -> bytes:
    words = re.findall(rb"[A-Za-z_]{2,}", contents) or [b""]
    word = rng.choice(words).decode("latin-1")
    return _replaced(rb"[A-Za-z_]{2,}", word, contents, rng)


def _nest(contents: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(contents) + 1)
    opening = rng.choice((b"[", b'{"a":', b"<a>", b"("))
    return contents[:start] + opening * 100_000 + contents[start:]


def _json_value(contents: bytes, rng: random.Random) -> bytes:
    """One value of a JSON file becomes another; other files are cut."""
    try:
        whole = json.loads(contents)
    except (ValueError, RecursionError):
        return _cut(contents, rng)
    places: list[tuple[dict | list, str | int]] = []

    def walk(node: object) -> None:
        pairs = (
            node.items()
            if isinstance(node, dict)
            else enumerate(node)
            if isinstance(node, list)
            else ()
        )
        for key, value in pairs:
            places.append((node, key))
            walk(value)

    walk(whole)
    if not places:
        return contents
    node, key = rng.choice(places)
    replacements = (None, True, -1, 0, 1e308, 10**40, 2**31, "", "x", [], {}, [[]],
                    [1e308] * 4, *TEXTS)  # fmt: skip
    if rng.random() < 0.2:
        del node[key]
    else:
        node[key] = rng.choice(replacements)
    return json.dumps(whole).encode()


FAULTS: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    _flip, _cut, _drop, _repeat, _number, _number, _word, _moved_word, _nest,
    _json_value, _json_value, _json_value,
)  # fmt: skip


def _replaced(pattern: bytes, by: str, contents: bytes, rng: random.Random) -> bytes:
    found = list(re.finditer(pattern, contents[: 2**16]))
    if not found:
        return contents
    one = rng.choice(found)
    return contents[: one.start()] + by.encode() + contents[one.end() :]


# ---------------------------------------------------------------- the good files


def _scene() -> dict:
    grey = {"type": "diffuse", "reflectance": 0.5}
    return {
        "camera": CAMERA,
        "materials": {
            "grey": grey,
            "metal": {"type": "conductor", "reflectance": 0.9, "alpha": 0.2},
            "lamp": {"type": "diffuse", "reflectance": 0.1},
        },
        "shapes": [
            {"id": "wall", "file": "wall.ply", "material": "grey"},
            {"id": "ball", "type": "sphere", "center": [0.5, 0.5, 0.4], "radius": 0.2,
             "material": "metal"},
        ],
        "lights": [
            {"type": "constant", "radiance": 1},
            {"type": "point", "position": [1, 1, 1], "intensity": 2},
        ],
    }  # fmt: skip


def _ply() -> str:
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS)
    faces = "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    return _ply_header("ascii") + rows + faces


def _ply_header(form: str) -> str:
    return (
        f"ply\nformat {form} 1.0\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nelement face 2\n"
        "property list uchar int vertex_indices\nend_header\n"
    )


def _binary_ply() -> bytes:
    corners = b"".join(struct.pack("<3f", *corner) for corner in CORNERS)
    faces = b"".join(struct.pack("<B3i", 3, *face) for face in FACES)
    return _ply_header("binary_little_endian").encode() + corners + faces


def _obj() -> str:
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    return (
        "mtllib room.mtl\n" + rows + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl red\n"
        "f 1/1 2/2 3/3\nusemtl lamp\nf 1/1 3/3 4/4\n"
    )


def _buffer() -> bytes:
    corners = np.array(CORNERS, "<f4").tobytes()
    return corners + np.array(FACES, "<u2").tobytes()


def _gltf(embedded: bool) -> dict:
    buffer: dict = {"byteLength": len(_buffer())}
    if embedded:
        text = base64.b64encode(_buffer()).decode()
        buffer["uri"] = f"data:application/octet-stream;base64,{text}"
    glow = {"emissiveFactor": [1, 1, 1]}
    paint = {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}}
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0},
            {"camera": 0, "translation": [0.5, 0.5, 2]},
        ],
        "cameras": [
            {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.01}}
        ],
        "materials": [paint | glow],
        "meshes": [
            {"primitives": [
                {"attributes": {"POSITION": 0}, "indices": 1, "material": 0}
            ]}
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
        "buffers": [buffer],
    }  # fmt: skip


def _glb() -> bytes:
    text = json.dumps(_gltf(embedded=False)).encode()
    text += b" " * (-len(text) % 4)
    data = _buffer() + bytes(-len(_buffer()) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


MITSUBA = """<scene version="3.0.0">
<sensor type="perspective"><float name="fov" value="40"/>
<transform name="to_world"><lookat origin="0.5, 0.5, 2" target="0.5, 0.5, 0"
 up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="4"/>
<integer name="height" value="4"/></film></sensor>
<bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.5, 0.4, 0.3"/></bsdf>
<shape type="ply"><string name="filename" value="wall.ply"/><ref id="grey"/></shape>
<shape type="sphere"><point name="center" x="0.5" y="0.5" z="0.5"/>
<float name="radius" value="0.1"/><emitter type="area">
<rgb name="radiance" value="3"/></emitter></shape>
<emitter type="constant"><rgb name="radiance" value="1"/></emitter>
</scene>
"""


def _reservoirs() -> dict[str, np.ndarray]:
    color = np.full((4, 4, 3), 0.5, np.float32)
    return {"color": color, "M": color[..., :1], "W": color[..., :1]}


def _write_pictures(folder: Path) -> None:
    color = _reservoirs()["color"]
    words = {"scene": "cornell-box", "method": "path", "light": "indirect"}
    error = np.full((4, 4, 3), 0.01, np.float32)
    write_exr(
        folder / "ours.exr", Image({"color": color, "standard_error": error}, words)
    )
    write_exr(folder / "restir.exr", Image(_reservoirs(), RUN))
    names = [f"ViewLayer.{kind}.{c}" for kind in ("Combined", "DiffDir") for c in "RGB"]
    channels = {name: color[..., 0].copy() for name in names}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(str(folder / "blender.exr"))


def _write_golden(folder: Path) -> None:
    probes = [*kernel_probes("float32")][:2]
    about = {"scene": "cornell-box", "size": 8, "seed": 0}
    contract = whole_contract()
    write_golden(folder, contract, "float32", probes, about, lambda *_: None)
