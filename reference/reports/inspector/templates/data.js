"use strict";
// Numbers of the page: one deflated block, cut into arrays that the manifest names.

async function readData() {
  const manifest = JSON.parse(document.getElementById("manifest").textContent);
  const text = document.getElementById("block").textContent.trim();
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream();
  const opened = stream.pipeThrough(new DecompressionStream("deflate"));
  const block = await new Response(opened).arrayBuffer();
  const kinds = {
    float32: Float32Array, int32: Int32Array, int8: Int8Array, uint8: Uint8Array,
  };
  const open = (value) => {
    if (Array.isArray(value)) return value.map(open);
    if (value === null || typeof value !== "object") return value;
    if ("offset" in value) {
      return new kinds[value.kind](block, value.offset, value.length);
    }
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, open(v)]));
  };
  return open(manifest);
}

const at = (array, row) => array[row];
const three = (array, row) => Array.from(array.subarray(3 * row, 3 * row + 3));

function number(value) {
  if (Number.isNaN(value)) return "NaN";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  return Number(value.toPrecision(7)).toString().replaceAll("-", "−");
}

const luminance = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
