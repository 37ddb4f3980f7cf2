"use strict";
// What the panel says of one pixel: its reservoirs, and the candidates of each pass.

const node = (tag, text, attributes = {}) => {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
};

function table(caption, heads, rows) {
  const made = node("table");
  made.append(node("caption", caption));
  const head = made.createTHead().insertRow();
  for (const text of heads) head.append(node("th", text, { scope: "col" }));
  const body = made.createTBody();
  for (const { cells, name, kind } of rows) {
    const row = body.insertRow();
    if (kind) row.className = kind;
    row.append(node("th", name, { scope: "row" }));
    for (const cell of cells) {
      row.append(typeof cell === "string" ? node("td", cell) : cellOf(cell));
    }
  }
  // Wide tables scroll by themselves, also by the keyboard.
  const frame = node("div", undefined, {
    class: "wide", tabindex: "0", role: "region", "aria-label": caption,
  });
  frame.append(made);
  return frame;
}

// A pixel that can be gone to.
function cellOf({ text, go }) {
  const cell = node("td");
  const button = node("button", text, { type: "button", class: "go" });
  button.addEventListener("click", go);
  cell.append(button);
  return cell;
}

const place = (row, width) => `(${row % width}, ${Math.floor(row / width)})`;
const point = (values) => values.map(number).join(" ");

// Quantities of a reservoir, as the buffers hold them, and what the pass knew of them.
const QUANTITIES = [
  ["M", "confidence M", (r, row) => number(at(r.M, row))],
  ["W", "contribution weight W, sr", (r, row) => number(at(r.W, row))],
  ["w", "sum of weights w", (r, row) => number(at(r.w, row))],
  ["total", "divided by (Z or M)", (r, row) => number(at(r.total, row))],
  ["p_hat", "target p̂", (r, row) => number(at(r.p_hat, row))],
  ["position", "sample point, m", (r, row) => point(three(r.position, row))],
  ["normal", "its normal", (r, row) => point(three(r.normal, row))],
  ["radiance", "its radiance", (r, row) => point(three(r.radiance, row))],
  ["pixel", "drawn by pixel", (r, row, width) => {
    const from = at(r.pixel, row);
    return from < 0 ? "–" : place(from, width);
  }],
  ["frame", "in frame", (r, row) => {
    const frame = at(r.frame, row);
    return frame < 0 ? "–" : number(frame);
  }],
];

// A run that does not have the frame that is looked at says which one it shows.
const headOf = (k, frame, number) =>
  "AB"[k] + (frame.number === number ? "" : `, frame ${frame.number ?? "of the file"}`);

function reservoirTables(runs, frames, row, number) {
  const names = [...new Set(frames.flatMap((f) => f.reservoirs.map((r) => r.name)))];
  return names.map((name) => {
    const each = frames.map((f) => f.reservoirs.find((r) => r.name === name));
    const rows = QUANTITIES.filter(([key]) => each.some((r) => r && r[key])).map(
      ([key, title, text]) => {
        const cells = each.map((r, k) => (r && r[key] ? text(r, row, runs[k].width) : "–"));
        const differs = cells.length > 1 && cells[0] !== cells[1];
        return { name: title, cells, kind: differs ? "differs" : undefined };
      },
    );
    const heads = runs.length > 1
      ? ["", ...frames.map((frame, k) => headOf(k, frame, number))] : ["", "value"];
    return table(`${name} reservoir`, heads, rows);
  });
}

const HEADS = [
  "candidate", "from pixel", "of frame", "M", "W, sr", "p̂ here", "Jacobian", "w", "share",
  "could make the kept one", "what became of it",
];
const COULD = ["no", "yes", "not asked"];

function candidatesOf(pass, row) {
  const list = [];
  for (let k = 0; k < pass.roles.length; k++) {
    const cell = row * pass.roles.length + k;
    const fate = pass.fate[cell];
    if (fate === pass.untried) continue;
    list.push({
      k, cell, fate,
      role: pass.roles[k],
      kept: pass.kept[row] === k && pass.w[cell] > 0,
      position: three(pass.position, cell),
      source: pass.source[cell],
    });
  }
  return list;
}

function candidateTable(run, pass, row, caption, go) {
  const found = candidatesOf(pass, row);
  const sum = found.reduce((total, { cell }) => total + pass.w[cell], 0);
  const rows = found.map(({ k, cell, fate, role, kept, source }) => ({
    name: `${k + 1} ${role}`,
    kind: kept ? "kept" : undefined,
    cells: fate === pass.absent ? [...Array(HEADS.length - 2).fill("–"), pass.fates[fate]] : [
      source < 0 ? "–" : {
        text: place(source, run.width), go: () => go(source, pass.frames[k]),
      },
      number(pass.frames[k]),
      number(pass.M[cell]),
      number(pass.W[cell]),
      number(pass.p_hat[cell]),
      number(pass.jacobian[cell]),
      number(pass.w[cell]),
      sum > 0 ? `${((100 * pass.w[cell]) / sum).toFixed(1)} %` : "–",
      COULD[pass.could[cell]],
      kept ? "kept" : pass.fates[fate],
    ],
  }));
  return table(caption, HEADS, rows);
}

function raysOf(run, frame, pass, row) {
  if (!pass || !frame.seen[row]) return [];
  const from = three(frame.x, row);
  const order = { dropped: 0, hidden: 1, competed: 2, kept: 3 };
  return candidatesOf(pass, row)
    .filter(({ fate }) => pass.shown[fate])
    .map(({ kept, fate, position }) => ({
      from, to: position, fate: kept ? "kept" : pass.shown[fate],
    }))
    .sort((a, b) => order[a.fate] - order[b.fate]);
}
