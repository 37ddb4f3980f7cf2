"""Pictures side by side, each with its caption."""

import numpy as np

from restir_gi.reference.images.display import Bytes, encode_png

GAP, MARGIN, INK, PAPER = 8, 10, (28, 31, 35), (251, 250, 248)
TILE = 384  # pixels that a tile is enlarged to, in whole steps


def strip(tiles: list[Bytes], captions: list[tuple[str, str]]) -> bytes:
    """PNG of pictures in a row.

    Parameters
    ----------
    tiles : list of (H, W, 3) uint8; of one size
    captions : list of (str, str); a title and a remark for each
    """
    from PIL import Image, ImageDraw, ImageFont

    scale = max(1, round(TILE / tiles[0].shape[1]))
    large = [tile.repeat(scale, axis=0).repeat(scale, axis=1) for tile in tiles]
    height, width = large[0].shape[:2]
    letter = max(10, width // 20)
    total = len(tiles) * (width + GAP) - GAP
    canvas = Image.new("RGB", (total, height + 2 * MARGIN + 3 * letter), PAPER)
    draw = ImageDraw.Draw(canvas)
    title, remark = ImageFont.load_default(letter), ImageFont.load_default(0.8 * letter)
    for index, (tile, words) in enumerate(zip(large, captions, strict=True)):
        left = index * (width + GAP)
        canvas.paste(Image.fromarray(tile), (left, 0))
        middle = left + width // 2, height + MARGIN
        draw.text(middle, words[0], INK, title, anchor="ma")
        below = middle[0], middle[1] + round(1.5 * letter)
        draw.text(below, words[1], INK, remark, anchor="ma")
    return encode_png(np.asarray(canvas))
