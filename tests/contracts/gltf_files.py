"""glTF files in the making, for tests."""

import base64
import json
from io import BytesIO

import numpy as np
from PIL import Image

from restir_gi.reference.scene.loaders.load import load_scene

TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)


def png(pixels):
    """Picture of 8-bit numbers: grey, RGB or RGBA."""
    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG")
    return buffer.getvalue()


class Gltf:
    """A glTF file in the making: one buffer, and the tree around it."""

    def __init__(self):
        self.data = b""
        self.tree = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}]}
        self.tree |= {"bufferViews": [], "accessors": [], "materials": []}
        self.tree |= {"nodes": [{"mesh": 0}]}

    def view(self, contents, **more):
        """Append bytes to the buffer."""
        start = len(self.data)
        self.data += contents + b"\0" * (-len(contents) % 4)
        self.tree["bufferViews"].append(
            {"buffer": 0, "byteOffset": start, "byteLength": len(contents), **more}
        )
        return len(self.tree["bufferViews"]) - 1

    def accessor(self, array, **more):
        """Append an array."""
        kinds = {"int8": 5120, "uint8": 5121, "uint16": 5123, "uint32": 5125}
        kinds["float32"] = 5126
        shape = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[
            array.reshape(len(array), -1).shape[1]
        ]
        entry = {"componentType": kinds[str(array.dtype)], "type": shape}
        entry |= {"count": len(array), "bufferView": self.view(array.tobytes())}
        self.tree["accessors"].append(entry | more)
        return len(self.tree["accessors"]) - 1

    def mesh(self, attributes, indices=None, **more):
        """Append a mesh of one primitive."""
        arrays = {name: self.accessor(array) for name, array in attributes.items()}
        primitive = {"attributes": arrays, **more}
        if indices is not None:
            primitive["indices"] = self.accessor(indices)
        self.tree.setdefault("meshes", []).append({"primitives": [primitive]})

    def texture(self, pixels):
        """Append a PNG."""
        image = {"bufferView": self.view(png(pixels)), "mimeType": "image/png"}
        self.tree.setdefault("images", []).append(image)
        self.tree.setdefault("textures", []).append({"source": 0})

    def write(self, path):
        """Write .gltf with a data URI, or .glb."""
        uri = (
            "data:application/octet-stream;base64,"
            + base64.b64encode(self.data).decode()
        )
        buffer = self.tree.setdefault("buffers", [{}])[0]
        buffer["byteLength"] = len(self.data)
        if path.suffix == ".gltf":
            buffer["uri"] = uri
            path.write_text(json.dumps(self.tree))
            return path
        text = json.dumps(self.tree).encode()
        text += b" " * (-len(text) % 4)
        chunks = len(text).to_bytes(4, "little") + b"JSON" + text
        chunks += len(self.data).to_bytes(4, "little") + b"BIN\0" + self.data
        head = b"glTF" + (2).to_bytes(4, "little")
        path.write_bytes(head + (12 + len(chunks)).to_bytes(4, "little") + chunks)
        return path


def triangle_file(material=None, **attributes):
    """One triangle, of material 0 if one is given."""
    gltf = Gltf()
    more = {}
    if material is not None:
        gltf.tree["materials"] = [material]
        more = {"material": 0}
    gltf.mesh({"POSITION": TRIANGLE, **attributes}, **more)
    return gltf


def load_gltf(gltf, tmp_path, lenient=False, suffix=".gltf"):
    return load_scene(gltf.write(tmp_path / f"a{suffix}"), lenient)


def gltf_material(tmp_path, lenient=False, extensions=None, **pbr):
    entry = {"name": "paint", "pbrMetallicRoughness": pbr}
    entry["extensions"] = extensions or {}
    scene = load_gltf(triangle_file(entry), tmp_path, lenient)
    return scene.meshes[0].material, scene
