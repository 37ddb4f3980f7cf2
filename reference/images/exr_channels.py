"""Which channels of an OpenEXR file make which layer of an image."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown

Channels = dict[str, NDArray[Any]]  # each (H, W)
MOST_LISTED = 20  # layers in a message
Layers = dict[str, NDArray[Any]]  # each (H, W, 1) or (H, W, 3)


def channels_of_layers(layers: Mapping[str, NDArray[Any]]) -> Channels:
    """Name the components: R, G, B for ``"color"``, else name.R, ... or name alone.

    Parameters
    ----------
    layers : mapping of str to (H, W, C) float32; C = 1 or 3

    Returns
    -------
    dict of str to (H, W) float32
        Contiguous copies: of a strided view the library writes the wrong numbers, and
        says nothing.

    Raises
    ------
    ValueError
        Two layers would write one channel.
    """
    channels: Channels = {}
    for name, layer in layers.items():
        if layer.shape[2] == 1:
            names = [name]
        else:
            names = ["R", "G", "B"] if name == "color" else _triple(name)
        for component, channel in enumerate(names):
            if channel in channels:
                raise ValueError(f"two layers would write the channel {channel!r}")
            channels[channel] = np.ascontiguousarray(layer[..., component])
    return channels


def layers_of_channels(
    channels: Channels, path: Path, layer: str | None = None
) -> Layers:
    """Group the channels into layers: the inverse of `channels_of_layers`.

    Raises UsageError: none of these; the message names the layers.

    Parameters
    ----------
    layer : str, optional
        Name of the layer that becomes ``"color"``, in full (``ViewLayer.Combined``) or
        its end (``Combined``) where no other layer ends so; ``color`` is R, G, B.  A
        single channel is grey.

    Returns
    -------
    dict of str to (H, W, C) float32
        ``"color"`` is ``layer``; or else R, G, B; or else the only layer that has an
        R, G and B; or else luminance Y, as grey.  ``"standard_error"`` is that of
        R, G, B, and left out beside another colour.
    """
    found = _color_channels(channels)
    color = found if layer is None else _asked_for(channels, layer, path)
    if color is None:
        raise UsageError(
            f"{path} has no colour channels R, G, B but {_listed(channels)}; choose one"
            " by --layer where a command has it, or save it as R, G, B"
        )
    layers = {"color": np.stack([channels[name] for name in color], axis=-1)}
    rest = {name: channels[name] for name in channels if name not in color}
    for root in _roots(rest):
        if root != "color":
            layers[root] = np.stack([rest.pop(c) for c in _triple(root)], axis=-1)
    if color != found:
        layers.pop("standard_error", None)
        rest.pop("standard_error", None)
    # In this order, lest a foreign channel called "color" replace the picture.
    return {name: channel[..., None] for name, channel in rest.items()} | layers


def _color_channels(channels: Channels) -> list[str] | None:
    """Names of the three channels to be shown; a grey one stands three times."""
    if {"R", "G", "B"} <= channels.keys():
        return ["R", "G", "B"]
    roots = _roots(channels)
    if len(roots) == 1:
        return _triple(roots[0])
    # Beside X and Z, or with chroma RY and BY, Y is not the whole picture.
    if "Y" in channels and not {"X", "Z", "RY", "BY"} & channels.keys():
        return ["Y", "Y", "Y"]
    return None


def _asked_for(channels: Channels, layer: str, path: Path) -> list[str]:
    """Names of the channels of one layer, three times the same if it is grey."""
    names = _names(channels)
    # A dot may part a view's name from a layer's, and may belong to either.
    ends = [name for name in names if name.endswith(f".{layer}")]
    if layer not in names and len(ends) > 1:
        raise UsageError(
            f"{path} has several layers {layer!r}, such as {ends[0]} and {ends[1]};"
            " name one in full"
        )
    name = layer if layer in names or not ends else ends[0]
    if name not in names:
        raise UsageError(f"{path}: {unknown('layer', layer, names, _listed(channels))}")
    if name == "color" and {"R", "G", "B"} <= channels.keys():
        return ["R", "G", "B"]
    return _triple(name) if name in _roots(channels) else [name] * 3


def _names(channels: Channels) -> list[str]:
    """All that ``layer`` may be: pictures, and then single channels."""
    roots = _roots(channels)
    apart = {channel for root in roots for channel in _triple(root)}
    plain = [] if not {"R", "G", "B"} <= channels.keys() else ["color"]
    apart |= {"R", "G", "B"} if plain else set()
    return list(dict.fromkeys([*plain, *roots, *sorted(channels.keys() - apart)]))


def _listed(channels: Channels) -> str:
    names = _names(channels)
    more = f" and {len(names) - MOST_LISTED} others" if names[MOST_LISTED:] else ""
    return (", ".join(names[:MOST_LISTED]) or "none") + more


def _roots(channels: Channels) -> list[str]:
    """Names that stand before .R, .G and .B alike."""
    candidates = [c.removesuffix(".R") for c in channels if c.endswith(".R")]
    return [root for root in candidates if set(_triple(root)) <= channels.keys()]


def _triple(root: str) -> list[str]:
    return [f"{root}.{component}" for component in "RGB"]
