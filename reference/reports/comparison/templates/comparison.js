"use strict";
(() => {
  const get = (id) => document.getElementById(id);
  const viewer = get("viewer"), stage = get("stage"), canvas = get("canvas");
  const [width, height] = [+viewer.dataset.width, +viewer.dataset.height];
  const figures = [...viewer.querySelectorAll("figure")];
  const images = Object.fromEntries(
    figures.map((figure) => [figure.dataset.view, figure.querySelector("img")]));
  const views = figures.map((figure) => [figure.dataset.view, figure.dataset.title]);
  views.splice(2, 0, ["split", "A | B"]);
  let view = "a", zoom = 1, at = null;

  // Without this script the figures stand one below the other; with it they share a stage.
  canvas.prepend(...Object.values(images));
  for (const element of viewer.querySelectorAll("[hidden]")) element.hidden = false;
  get("probe").hidden = true;
  for (const [name, title] of views) {
    const label = document.createElement("label"), input = document.createElement("input");
    Object.assign(input, { type: "radio", name: "view", value: name });
    input.addEventListener("change", () => show(name));
    label.append(input, title);
    get("views").append(label);
  }

  function show(name) {
    view = name;
    const split = name === "split";
    for (const [key, image] of Object.entries(images)) {
      image.classList.toggle("shown", key === name || (split && "ab".includes(key)));
      image.style.clipPath = "";
    }
    if (split) images.b.style.clipPath = `inset(0 0 0 ${get("split").value}%)`;
    get("divider").hidden = !split;
    get("divider").style.left = `${get("split").value}%`;
    for (const figure of figures) figure.hidden = figure.dataset.view !== name;
    get("split-label").style.visibility = split ? "visible" : "hidden";
    document.querySelector(`#views input[value=${name}]`).checked = true;
  }

  function swap() {
    show(view === "a" ? "b" : "a");
  }

  function scale(factor) {
    const middle = (client, scroll, size) => (scroll + client / 2) / (size * zoom);
    const x = middle(stage.clientWidth, stage.scrollLeft, width);
    const y = middle(stage.clientHeight, stage.scrollTop, height);
    zoom = Math.min(Math.max(factor, 1 / 16), 64);
    canvas.style.width = `${width * zoom}px`;
    canvas.style.height = `${height * zoom}px`;
    canvas.classList.toggle("crisp", zoom >= 1);
    stage.scrollLeft = x * width * zoom - stage.clientWidth / 2;
    stage.scrollTop = y * height * zoom - stage.clientHeight / 2;
    get("zoom").value = `${Math.round(zoom * 100)} %`;
    if (at) probe(...at);
  }

  function fit() {
    const room = Math.min(stage.clientWidth / width, 0.75 * innerHeight / height);
    scale(room >= 1 ? Math.min(Math.floor(room), 16) : room);
  }

  function values(id) {
    if (!get(id)) return null;
    const bytes = Uint8Array.from(atob(get(id).textContent), (c) => c.charCodeAt(0));
    return new Float32Array(bytes.buffer);
  }
  const [a, b] = [values("values-a"), values("values-b")];

  function probe(x, y) {
    at = [Math.min(Math.max(x, 0), width - 1), Math.min(Math.max(y, 0), height - 1)];
    const i = 3 * (at[1] * width + at[0]), line = [`pixel ${at[0]}, ${at[1]}`];
    if (a) {
      const pixel = (from) => Array.from(from.slice(i, i + 3));
      const text = (rgb) => rgb.map((v) => v.toPrecision(4).padStart(11)).join(" ");
      const [va, vb] = [pixel(a), pixel(b)];
      line[0] += "\n";
      line.push(`A   ${text(va)}\n`, `B   ${text(vb)}\n`,
        `A−B ${text(va.map((v, k) => v - vb[k]))}`);
    }
    get("readout").textContent = line.join("");
    const box = get("probe");
    box.hidden = false;
    Object.assign(box.style, {
      left: `${at[0] * zoom}px`, top: `${at[1] * zoom}px`,
      width: `${zoom}px`, height: `${zoom}px`,
    });
  }

  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect();
    probe(Math.floor((event.clientX - box.left) / zoom), Math.floor((event.clientY - box.top) / zoom));
  });
  canvas.addEventListener("click", swap);
  get("split").addEventListener("input", () => show("split"));
  get("in").addEventListener("click", () => scale(zoom * 2));
  get("out").addEventListener("click", () => scale(zoom / 2));
  get("fit").addEventListener("click", fit);
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  viewer.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { key } = event, [x, y] = at ?? [width >> 1, height >> 1];
    if (event.target === stage && key in arrows) probe(x + arrows[key][0], y + arrows[key][1]);
    else if (key === "x" || key === "X") swap();
    else if (key === "+" || key === "=") scale(zoom * 2);
    else if (key === "-") scale(zoom / 2);
    else if (views[key - 1]) show(views[key - 1][0]);
    else return;
    event.preventDefault();
  });
  show("a");
  fit();
})();
