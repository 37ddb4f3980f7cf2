"""The tree of nodes of a glTF file: where each stands in the world."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.loaders.gltf_buffers import Document, read_accessor
from restir_gi.reference.scene.loaders.gltf_check import named

OFF_UNIT = 0.01
"""By how much a quaternion may be off length 1: four bytes, each off by 1/254."""
FARTHEST = 1e50
"""Entries of matrices, of which three may still be multiplied."""


def nodes(document: Document) -> Iterator[tuple[str, dict[str, Any], Scalars]]:
    """All nodes of the default scene, in depth-first order.

    Yields
    ------
    str, dict and (4, 4) float64
        What messages call it, as in the file, and its matrix to the world.

    Raises
    ------
    UsageError
        A node hangs in the tree twice, or beyond the range of numbers.
    """
    tree = document.tree
    listed = tree.get("nodes", [])
    if tree.get("scenes"):
        roots = document.entry("scenes", tree.get("scene", 0)).get("nodes", [])
    else:
        children = {child for node in listed for child in node.get("children", [])}
        roots = sorted(set(range(len(listed))) - children)
    waiting = [(index, np.eye(4)) for index in reversed(roots)]
    seen: set[int] = set()
    while waiting:
        index, parent = waiting.pop()
        if index in seen:
            document.ledger.stop(f"node {index} hangs in the tree twice")
        seen.add(index)
        node = listed[index]
        where = named("node", node, index)
        matrix = parent @ _local_matrix(node, where, document)
        if not np.abs(matrix).max() <= FARTHEST:
            document.ledger.stop(f"{where} stands beyond the range of numbers")
        yield where, node, matrix
        waiting += [(child, matrix) for child in reversed(node.get("children", []))]


def instances(
    document: Document, where: str, node: dict[str, Any], matrix: Scalars
) -> list[Scalars]:
    """Where the mesh of a node stands: once, or as EXT_mesh_gpu_instancing has it.

    Parameters
    ----------
    matrix : (4, 4) float64; of the node, to the world

    Returns
    -------
    list of (4, 4) float64; to the world

    Raises
    ------
    UsageError
        The attributes of the instances differ in number.
    """
    extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
    if extension is None:
        return [matrix]
    types = {"TRANSLATION": "VEC3", "ROTATION": "VEC4", "SCALE": "VEC3"}
    words = {"TRANSLATION": "translation", "ROTATION": "rotation", "SCALE": "scale"}
    given = extension["attributes"]
    columns = {
        words[name]: read_accessor(document, given[name], (kind,), f"{where}, {name}")
        for name, kind in types.items()
        if name in given
    }
    counts = {len(column) for column in columns.values()}
    if len(counts) > 1:
        told = ", ".join(str(count) for count in sorted(counts))
        problem = f"{where}: the attributes of its instances number {told}"
        document.ledger.stop(f"{problem}; they must be as many")
    placed = []
    for row in range(max(counts, default=0)):
        local = {word: column[row] for word, column in columns.items()}
        placed.append(matrix @ _local_matrix(local, where, document))
        if not np.abs(placed[-1]).max() <= FARTHEST:
            problem = f"instance {row} stands beyond the range of numbers"
            document.ledger.stop(f"{where}: {problem}")
    return placed


def _local_matrix(node: dict[str, Any], where: str, document: Document) -> Scalars:
    if "matrix" in node:
        matrix = np.array(node["matrix"], float).reshape(4, 4).T
        if not np.array_equal(matrix[3], [0, 0, 0, 1]):
            problem = f"{where}: its matrix is not affine"
            document.ledger.stop(f"{problem}; its last row must be 0, 0, 0, 1")
        return matrix
    matrix = np.eye(4)
    quaternion = np.array(node.get("rotation", [0, 0, 0, 1]), float)
    size = float(np.hypot(np.hypot(*quaternion[:2]), np.hypot(*quaternion[2:])))
    if not abs(size - 1) <= OFF_UNIT:
        problem = f"{where}: its rotation is a quaternion of length {size:.3g}"
        document.ledger.stop(f"{problem}; it must be 1")
    x, y, z, w = quaternion
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix[:3, :3] = rotation * np.array(node.get("scale", [1, 1, 1]), float)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix
