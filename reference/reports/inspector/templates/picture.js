"use strict";
// The image: what each view shows of a frame, and the pixel that is looked at.

const encode = (value) => {
  const v = Math.min(Math.max(value, 0), 1);
  return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
};

// Blue where B is darker, red where it is brighter, in shares of `most`.
const signed = (value, most) => {
  const share = most > 0 ? Math.max(-1, Math.min(1, value / most)) : 0;
  const rest = 255 * (1 - Math.abs(share));
  return share < 0 ? [rest, rest, 255] : [255, rest, rest];
};

const grey = (value, most) => Array(3).fill(most > 0 ? 255 * Math.min(1, value / most) : 0);

function rowsOf(array, width) {
  const rows = [];
  for (let row = 0; row < array.length / width; row++) rows.push(row);
  return rows;
}

function views(runs) {
  const list = runs.map((run, k) => ({
    name: runs.length > 1 ? `${"AB"[k]}: picture` : "Picture",
    exposed: true,
    paint: (frames, exposure) => (row) =>
      three(frames[k].color, row).map((c) => encode(c * exposure)),
  }));
  runs.forEach((run, k) => {
    for (const kind of ["M", "W"]) {
      if (!run.frames[0].reservoirs.some((r) => r[kind])) continue;
      list.push({
        name: `${runs.length > 1 ? `${"AB"[k]}: ` : ""}${kind} of what is shown`,
        paint: (frames) => {
          const values = frames[k].reservoirs.at(-1)[kind];
          const most = values.reduce((a, b) => Math.max(a, b), 0);
          return (row) => grey(values[row], most);
        },
      });
    }
  });
  if (runs.length > 1) {
    list.push({
      name: "B − A: luminance, red where B is brighter",
      paint: (frames) => {
        const [a, b] = frames.map((frame) => frame.color);
        const off = (row) => luminance(three(b, row)) - luminance(three(a, row));
        const most = rowsOf(a, 3).reduce((m, row) => Math.max(m, Math.abs(off(row))), 0);
        return (row) => signed(off(row), most);
      },
    });
  }
  return list;
}

function paint(canvas, color, width, height) {
  canvas.width = width;
  canvas.height = height;
  const image = new ImageData(width, height);
  for (let row = 0; row < width * height; row++) {
    image.data.set([...color(row), 255], 4 * row);
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
}
