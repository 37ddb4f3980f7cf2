"use strict";
// One state, drawn anew whenever a part of it changes.

const find = (id) => document.getElementById(id);

function start({ runs, exposure }) {
  // The run with most frames leads; of another one its last stands for what it has not.
  const { frames } = runs.reduce((a, b) => (b.frames.length > a.frames.length ? b : a));
  const state = { frame: frames.length - 1, row: 0, view: 0, exposure, pass: -1 };
  const { width, height } = runs[0];
  const list = views(runs);
  const room = new Room(find("room"));
  const shown = () => frames[state.frame].number ?? "of the file";
  const now = () => runs.map((run) => frameOf(run, frames[state.frame].number));
  const passes = () => runs.flatMap((run, k) =>
    now()[k].passes.map((pass) => ({ run, pass, frame: now()[k], name: nameOf(runs, k, pass) })));

  list.forEach(({ name }, k) => find("view").append(node("option", name, { value: k })));
  find("frame").max = frames.length - 1;
  find("x").max = width - 1;
  find("y").max = height - 1;

  function drawImage() {
    const view = list[state.view];
    paint(find("image"), view.paint(now(), state.exposure), width, height);
    find("exposure").disabled = !view.exposed;
    find("image").setAttribute("aria-label",
      `${view.name}, frame ${shown()}. Arrow keys choose a pixel.`);
    const cursor = find("cursor");
    cursor.style.left = `${(100 * (state.row % width)) / width}%`;
    cursor.style.top = `${(100 * Math.floor(state.row / width)) / height}%`;
    cursor.style.width = `${100 / width}%`;
    cursor.style.height = `${100 / height}%`;
  }

  function drawPanel() {
    const [x, y] = [state.row % width, Math.floor(state.row / width)];
    find("frame").value = state.frame;
    find("frame-number").textContent = shown();
    find("x").value = x;
    find("y").value = y;
    const colors = now().map((frame) => point(three(frame.color, state.row)));
    find("where").textContent =
      `Pixel (${x}, ${y}), row ${state.row}, frame ${shown()}`;
    find("color").textContent = colors
      .map((text, k) => `${runs.length > 1 ? `${"AB"[k]}: ` : ""}${text}`).join("; ");
    find("reservoirs").replaceChildren(
      ...reservoirTables(runs, now(), state.row, frames[state.frame].number));
    find("candidates").replaceChildren(
      ...passes().map(({ run, pass, name }) =>
        candidateTable(run, pass, state.row, name, visit)));
  }

  function drawRoom() {
    const all = passes();
    const chosen = all.at(state.pass) ?? all.at(-1);
    find("pass").replaceChildren(...all.map(({ name }, k) =>
      node("option", name, { value: k, ...(all[k] === chosen ? { selected: "" } : {}) })));
    find("pass").disabled = all.length < 2;
    if (!chosen) return;
    const { run, frame, pass } = chosen;
    room.show(frame, state.exposure, raysOf(run, frame, pass, state.row));
  }

  function draw() {
    drawImage();
    drawPanel();
    drawRoom();
  }

  function set(change) {
    Object.assign(state, change);
    draw();
  }

  const step = (by) =>
    set({ frame: Math.max(0, Math.min(frames.length - 1, state.frame + by)) });
  const go = (x, y) => set({
    row: Math.max(0, Math.min(height - 1, y)) * width + Math.max(0, Math.min(width - 1, x)),
  });
  const walk = (dx, dy) => go((state.row % width) + dx, Math.floor(state.row / width) + dy);

  // To a pixel, and its frame where the page holds it.
  function visit(row, number) {
    const frame = frames.findIndex((one) => one.number === number);
    set({ row, ...(frame < 0 ? {} : { frame }) });
    find("image").focus();
  }

  // Pixels whose shown colour is not the same in both runs.
  function next() {
    const [a, b] = now().map((frame) => frame.color);
    const rows = width * height;
    for (let ahead = 1; ahead <= rows; ahead++) {
      const row = (state.row + ahead) % rows;
      if (three(a, row).some((value, k) => value !== three(b, row)[k])) return set({ row });
    }
    find("where").textContent = "No pixel of this frame differs";
  }

  find("image").addEventListener("click", (event) => {
    const box = find("image").getBoundingClientRect();
    go(Math.floor(((event.clientX - box.left) * width) / box.width),
      Math.floor(((event.clientY - box.top) * height) / box.height));
  });
  find("image").addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const far = event.shiftKey ? 8 : 1;
    const moves = {
      ArrowLeft: () => walk(-far, 0), ArrowRight: () => walk(far, 0),
      ArrowUp: () => walk(0, -far), ArrowDown: () => walk(0, far),
      "[": () => step(-1), "]": () => step(1),
      PageUp: () => step(-1), PageDown: () => step(1),
      ...(runs.length > 1 ? { n: next } : {}),
    };
    if (!moves[event.key]) return;
    moves[event.key]();
    event.preventDefault();
  });
  find("before").addEventListener("click", () => step(-1));
  find("after").addEventListener("click", () => step(1));
  find("frame").addEventListener("input", (event) => set({ frame: Number(event.target.value) }));
  find("view").addEventListener("change", (event) => set({ view: Number(event.target.value) }));
  find("pass").addEventListener("change", (event) => set({ pass: Number(event.target.value) }));
  find("exposure").addEventListener("input", (event) =>
    set({ exposure: exposure * 2 ** Number(event.target.value) }));
  for (const axis of ["x", "y"]) {
    find(axis).addEventListener("change", () => go(Number(find("x").value), Number(find("y").value)));
  }
  if (runs.length > 1) find("next").addEventListener("click", next);
  new ResizeObserver(drawRoom).observe(find("room"));
  draw();
  document.body.dataset.ready = "";
}

const frameOf = (run, number) =>
  run.frames.find((frame) => frame.number === number) ?? run.frames.at(-1);

const nameOf = (runs, k, pass) =>
  `${runs.length > 1 ? `${"AB"[k]}: ` : ""}candidates of the ${pass.name} pass`;

readData().then(start, (error) => {
  find("where").textContent = `The page cannot be read: ${error.message}`;
});
