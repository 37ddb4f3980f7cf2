"use strict";
// The scene as points and edges, and the rays of one pixel in it.

const minus = (a, b) => a.map((value, k) => value - b[k]);
const plus = (a, b, t) => a.map((value, k) => value + t * b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
const unit = (a) => a.map((value) => value / (Math.hypot(...a) || 1));

const MOST_POINTS = 12000;

// How the fate of a candidate is drawn: never by colour alone.
const STROKES = {
  kept: { width: 4, dash: [], color: "--kept" },
  competed: { width: 1.5, dash: [], color: "--good" },
  hidden: { width: 1.5, dash: [6, 4], color: "--bad" },
  dropped: { width: 1, dash: [2, 4], color: "--quiet" },
};

class Room {
  constructor(canvas) {
    this.canvas = canvas;
    this.turn = 0;
    this.lift = 0;
    this.zoom = 1;
    this.rays = [];
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.held = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!this.held) return;
      this.rotate((event.clientX - this.held[0]) / 150, (event.clientY - this.held[1]) / 150);
      this.held = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, () => { this.held = null; });
    }
    canvas.addEventListener("keydown", (event) => {
      const moves = {
        ArrowLeft: () => this.rotate(-0.1, 0), ArrowRight: () => this.rotate(0.1, 0),
        ArrowUp: () => this.rotate(0, -0.1), ArrowDown: () => this.rotate(0, 0.1),
        "+": () => this.scale(1.15), "=": () => this.scale(1.15), "-": () => this.scale(1 / 1.15),
        Home: () => { this.turn = this.lift = 0; this.zoom = 1; this.draw(); },
      };
      if (!moves[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      moves[event.key]();
      event.preventDefault();
    });
  }

  rotate(turn, lift) {
    this.turn += turn;
    this.lift = Math.max(-1.5, Math.min(1.5, this.lift + lift));
    this.draw();
  }

  scale(by) {
    this.zoom *= by;
    this.draw();
  }

  show(frame, exposure, rays) {
    Object.assign(this, { frame, exposure, rays });
    this.draw();
  }

  // Orbit about the middle of what the camera sees, beginning at the camera itself.
  eye() {
    const { camera, middle } = this.frame;
    const up = unit(camera.up);
    const back = minus(camera.position, middle);
    const high = dot(back, up);
    const flat = minus(back, up.map((value) => value * high));
    const side = cross(up, flat);
    const around = plus(flat.map((v) => v * Math.cos(this.turn)), side, Math.sin(this.turn));
    const length = Math.hypot(...back) || 1;
    const angle = Math.asin(Math.max(-1, Math.min(1, high / length))) + this.lift;
    const bounded = Math.max(-1.5, Math.min(1.5, angle));
    const out = plus(
      unit(around).map((v) => v * Math.cos(bounded)), up, Math.sin(bounded),
    );
    return { position: plus(middle, out, length), up, toward: out.map((v) => -v) };
  }

  projection() {
    const { position, up, toward } = this.eye();
    const across = unit(cross(toward, up));
    const above = cross(across, toward);
    const right = this.frame.camera.mirrored ? across.map((v) => -v) : across;
    const { width, height } = this.canvas;
    const scale = (this.zoom * Math.min(width, height)) / (2 * this.frame.camera.tangent);
    const near = 1e-3 * Math.hypot(...minus(this.frame.camera.position, this.frame.middle));
    const seen = (p) => {
      const off = minus(p, position);
      return [dot(off, right), dot(off, above), dot(off, toward)];
    };
    const flat = ([x, y, z]) => [width / 2 + (scale * x) / z, height / 2 - (scale * y) / z];
    const point = (p) => {
      const q = seen(p);
      return q[2] > near ? [...flat(q), q[2]] : null;
    };
    const segment = (a, b) => {
      let [p, q] = [seen(a), seen(b)];
      if (p[2] <= near && q[2] <= near) return null;
      const cut = (from, to) => plus(from, minus(to, from), (near - from[2]) / (to[2] - from[2]));
      if (p[2] < near) p = cut(p, q);
      if (q[2] < near) q = cut(q, p);
      return [flat(p), flat(q)];
    };
    return { point, segment };
  }

  draw() {
    const { canvas, frame } = this;
    if (!frame || !frame.x) return;
    canvas.width = canvas.clientWidth * devicePixelRatio || 300;
    canvas.height = canvas.clientHeight * devicePixelRatio || 200;
    const context = canvas.getContext("2d");
    const style = getComputedStyle(canvas);
    context.clearRect(0, 0, canvas.width, canvas.height);
    const { point, segment } = this.projection();
    this.drawPoints(context, point);
    this.drawEdges(context, segment, style.getPropertyValue("--line"));
    for (const ray of this.rays) this.drawRay(context, segment, point, style, ray);
  }

  drawPoints(context, point) {
    const { x, color, seen } = this.frame;
    const rows = x.length / 3;
    const step = Math.max(1, Math.ceil(rows / MOST_POINTS));
    const size = Math.max(2, (this.canvas.height / Math.sqrt(rows / step)) * 0.35);
    const placed = [];
    for (let row = 0; row < rows; row += step) {
      const p = seen[row] ? point(three(x, row)) : null;
      if (p) placed.push([p[2], p[0], p[1], row]);
    }
    placed.sort((a, b) => b[0] - a[0]);
    context.globalAlpha = 0.6;
    for (const [, px, py, row] of placed) {
      const rgb = three(color, row).map((c) => Math.round(encode(c * this.exposure)));
      context.fillStyle = `rgb(${rgb.join(" ")})`;
      context.fillRect(px - size / 2, py - size / 2, size, size);
    }
    context.globalAlpha = 1;
  }

  drawEdges(context, segment, color) {
    const { edges } = this.frame;
    if (!edges) return;
    context.setLineDash([]);
    context.lineWidth = 1;
    context.strokeStyle = color;
    context.beginPath();
    for (let k = 0; k < edges.length / 6; k++) {
      const line = segment(three(edges, 2 * k), three(edges, 2 * k + 1));
      if (!line) continue;
      context.moveTo(...line[0]);
      context.lineTo(...line[1]);
    }
    context.stroke();
  }

  drawRay(context, segment, point, style, { from, to, fate }) {
    const { width, dash, color } = STROKES[fate];
    const line = segment(from, to);
    if (!line) return;
    context.strokeStyle = context.fillStyle = style.getPropertyValue(color);
    context.lineWidth = width * devicePixelRatio;
    context.setLineDash(dash.map((part) => part * devicePixelRatio));
    context.beginPath();
    context.moveTo(...line[0]);
    context.lineTo(...line[1]);
    context.stroke();
    const end = point(to);
    if (!end) return;
    context.beginPath();
    context.arc(end[0], end[1], (width + 1.5) * devicePixelRatio, 0, 7);
    context.fill();
  }
}
