// What is drawn over one view: points, lines, names, and how far other views put them.
// Joined with the other files here into one module by frame_canvas.py.

const WARN = "#ffd1c4"; // words about a point that contradicts the other views

// The colour around a mark: white around dark ones (relative luminance below 0.2).
function rim(colour, opacity) {
  const hex = /^#[0-9a-f]{6}$/i.test(colour) ? colour : "#ffffff";
  const [r, g, b] = [1, 3, 5].map((at) => (parseInt(hex.slice(at, at + 2), 16) / 255) ** 2.2);
  const dark = 0.2126 * r + 0.7152 * g + 0.0722 * b < 0.2;
  return dark ? `rgba(255, 255, 255, ${opacity})` : `rgba(0, 0, 0, ${opacity})`;
}

// A Stage (stage.js) as far as it is drawn: it has bitmap, overlay, stick, tint, drag, over, aim,
// live (what linked.js says of a point in the hand), zoom, the canvases image and marks, and toCanvas(u, v).
class Marks {
  // --- what other views say --------------------------------------------------------------

  // Where the other views put each point: one place, or the two ends of a line.
  get guides() {
    const { live, overlay } = this;
    const own = live && live.guide ? { [live.id]: live.guide } : {};
    return { ...own, ...overlay.guides };
  }

  // How far (u, v) is from where the other views put a point, px; null where they do not say.
  off(id, u, v, guide = this.guides[id]) {
    if (!guide) return null;
    const [[u0, v0], end] = guide;
    if (!end) return Math.hypot(u - u0, v - v0);
    const [du, dv] = [end[0] - u0, end[1] - v0];
    return Math.abs((u - u0) * dv - (v - v0) * du) / Math.hypot(du, dv);
  }

  // How far off a point is, beside its name; while it is in the hand in another view, at once.
  nameWords({ id, u, v }) {
    const { live, overlay } = this;
    if (!live || live.id !== id || live.off == null) return this.offWords(id, u, v, overlay.residuals);
    return `${live.off > (overlay.limit_px ?? Infinity) ? "⚠ " : ""}${pixels(live.off)}`;
  }

  // The same in words, beside a point: for clicks always, for tracks where it is too much.
  offWords(id, u, v, always, guide) {
    const off = this.off(id, u, v, guide);
    if (off === null) return "";
    const much = off > (this.overlay.limit_px ?? Infinity);
    if (!much && !always) return "";
    return `${much ? "⚠ " : ""}${pixels(off)}`;
  }

  // --- drawing ---------------------------------------------------------------------

  drawImage() {
    const g = this.image.getContext("2d", { willReadFrequently: true });
    const { scale, tx, ty } = this.zoom;
    g.setTransform(1, 0, 0, 1, 0, 0);
    if (!this.bitmap) {
      g.clearRect(0, 0, this.image.width, this.image.height);
      return;
    }
    // enlarged pixels stay squares: what the camera saw, nothing in between
    g.imageSmoothingEnabled = scale < 2;
    g.setTransform(scale, 0, 0, scale, tx, ty);
    g.drawImage(this.bitmap, 0, 0, this.W, this.H);
  }

  drawMarks(selected) {
    const g = this.marks.getContext("2d");
    const k = window.devicePixelRatio || 1;
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.clearRect(0, 0, this.marks.width, this.marks.height);
    g.lineJoin = g.lineCap = "round";
    const { lines = [], hollow = [], points = [], others = [] } = this.overlay;
    this.drawTint(g);
    for (const line of lines) this.drawLine(g, k, line);
    const { live } = this;
    if (live && live.line) this.drawLine(g, k, { at: live.line, colour: live.colour, dash: true });
    // what follows the hand stands for where the views put its point before
    for (const mark of hollow) if (!live || !live.at || mark.id !== live.id) this.drawHollow(g, k, mark);
    if (live && live.at) this.drawHollow(g, k, { u: live.at[0], v: live.at[1], colour: live.colour });
    const named = new Set(points.map((point) => point.id));
    const drag = this.drag;
    const tips = this.stick ? this.stick.handles().filter(({ kind }) => kind === "tip") : [];
    for (const other of others)
      this.drawOther(g, k, other, [...points, ...tips].find(({ id }) => id === other.id));
    for (const point of points) this.drawPoint(g, k, point, point.id === selected);
    if (this.stick) {
      const held = drag && drag.kind === "point" ? drag.point : null;
      this.stick.draw(g, k, this, held, this.over);
    }
    const marks = [...points, ...hollow.filter((mark) => !named.has(mark.id)), ...tips];
    this.drawNames(g, k, marks, [...points, ...tips]);
    this.drawAim(g, k);
    this.host.closer.draw(this, g, k);
    if (drag && drag.kind === "rectangle") {
      const box = [drag.x, drag.y, drag.x1 - drag.x, drag.y1 - drag.y];
      g.setLineDash([6 * k, 4 * k]);
      this.outlined(g, k, 1.5, "#fff", () => g.strokeRect(...box));
      g.setLineDash([]);
    }
  }

  // A picture over part of the view: what the tracker makes of it.
  drawTint(g) {
    if (!this.tint || !this.tint.image.complete) return;
    const [u0, v0, u1, v1] = this.tint.box;
    const [x0, y0] = this.toCanvas(u0 - 0.5, v0 - 0.5);
    const [x1, y1] = this.toCanvas(u1 - 0.5, v1 - 0.5);
    g.imageSmoothingEnabled = false;
    g.drawImage(this.tint.image, x0, y0, x1 - x0, y1 - y0);
  }

  // How far from the other views' place a point is that is dragged or about to be clicked.
  drawAim(g, k) {
    const { drag } = this;
    const held = drag && drag.kind === "point" && drag.moved && !drag.point.kind ? drag.point : null;
    const mark = held || (drag || this.over ? null : this.aim);
    const words = mark && this.offWords(mark.id, mark.u, mark.v, true, mark.guide);
    if (!words) return;
    const [x, y] = this.toCanvas(mark.u, mark.v);
    const text = `${mark.id} ${words}`;
    g.font = `600 ${13 * k}px system-ui, sans-serif`;
    const left = Math.min(x + 20 * k, this.marks.width - g.measureText(text).width - 4 * k);
    this.write(g, k, text, left, Math.max(y - 20 * k, 15 * k), words.startsWith("⚠") ? WARN : "#fff");
  }

  write(g, k, text, x, y, colour) {
    g.lineWidth = 3.5 * k;
    g.strokeStyle = rim(colour, 0.75);
    g.strokeText(text, x, y);
    g.fillStyle = colour;
    g.fillText(text, x, y);
  }

  // Every mark has a rim, dark or, for dark colours, white: it can be told from any fur.
  outlined(g, k, width, colour, stroke, wide = 2) {
    g.lineWidth = (width + wide) * k;
    g.strokeStyle = rim(colour, 0.65);
    stroke();
    g.lineWidth = width * k;
    g.strokeStyle = colour;
    stroke();
  }

  // Trails (fading towards the past), sticks, axes, and dashed epipolar lines.
  drawLine(g, k, { at, colour, dash, fade }) {
    g.setLineDash(dash ? [8 * k, 6 * k] : []);
    const stroke = (first, last) => () => {
      g.beginPath();
      for (let i = first; i <= last; i++) {
        if (!at[i]) continue; // a gap in the track
        const place = this.toCanvas(...at[i]);
        if (i > first && at[i - 1]) g.lineTo(...place);
        else g.moveTo(...place);
      }
      g.stroke();
    };
    if (!fade) this.outlined(g, k, 1.8, colour, stroke(0, at.length - 1));
    else for (let i = 1; i < at.length; i++) {
      if (!at[i] || !at[i - 1]) continue;
      g.globalAlpha = 0.25 + (0.75 * i) / at.length;
      this.outlined(g, k, 1.8, colour, stroke(i - 1, i), 0.7);
    }
    g.globalAlpha = 1;
    g.setLineDash([]);
  }

  // Where the other views say the point is: a hollow diamond.
  drawHollow(g, k, { u, v, colour }) {
    const [x, y] = this.toCanvas(u, v);
    const r = 9 * k;
    this.outlined(g, k, 1.5, colour, () => {
      g.beginPath();
      g.moveTo(x, y - r);
      g.lineTo(x + r, y);
      g.lineTo(x, y + r);
      g.lineTo(x - r, y);
      g.closePath();
      g.stroke();
    });
  }

  // Where the tracks that are compared have a point: a dashed ring, joined to this track's point.
  drawOther(g, k, { u, v, colour }, point) {
    const [x, y] = this.toCanvas(u, v);
    g.setLineDash([4 * k, 3 * k]);
    this.outlined(g, k, 1.4, colour, () => { g.beginPath(); g.arc(x, y, 10 * k, 0, 2 * Math.PI); g.stroke(); });
    g.setLineDash([]);
    if (!point) return;
    this.outlined(g, k, 1, colour, () => {
      g.beginPath();
      g.moveTo(x, y);
      g.lineTo(...this.toCanvas(point.u, point.v));
      g.stroke();
    }, 1.5);
  }

  // A ring that leaves its middle free, so that the pixel under it can be seen:
  // dashed where predicted, doubled where a person placed it.
  drawPoint(g, k, point, selected) {
    const { id, u, v, colour, origin } = point;
    const [x, y] = this.toCanvas(u, v);
    const ring = (r) => () => { g.beginPath(); g.arc(x, y, r * k, 0, 2 * Math.PI); g.stroke(); };
    g.setLineDash(origin === "predicted" || origin === "reprojected" ? [3 * k, 4 * k] : []);
    this.outlined(g, k, 2.2, colour, ring(7));
    g.setLineDash([]);
    if (origin === "edited") this.outlined(g, k, 1.4, colour, ring(11));
    if (selected || (this.over && this.over.id === id)) {
      g.lineWidth = 1.5 * k;
      g.strokeStyle = "#fff";
      ring(14)();
    }
    this.outlined(g, k, 1, colour, () => { g.beginPath(); g.arc(x, y, 0.6 * k, 0, 7); g.stroke(); });
  }

  // The name beside each mark, where it covers neither a mark nor another name.
  drawNames(g, k, marks, points) {
    const dragged = this.drag && this.drag.kind === "point" && this.drag.moved;
    const size = 13 * k;
    const taken = points.map(({ u, v }) => {
      const [x, y] = this.toCanvas(u, v);
      return [x - 8 * k, y - 8 * k, x + 8 * k, y + 8 * k];
    });
    const free = (box) => taken.every((t) => box[2] < t[0] || box[0] > t[2] || box[3] < t[1] || box[1] > t[3]);
    g.font = `600 ${size}px system-ui, sans-serif`;
    for (const mark of marks) {
      if (dragged && this.drag.point.id === mark.id) continue; // must not hide what is aimed at
      const [x, y] = this.toCanvas(mark.u, mark.v);
      const off = points.includes(mark) ? this.nameWords(mark) : "";
      const text = off ? `${mark.id} ${off}` : mark.id;
      const w = g.measureText(text).width;
      const boxes = [[10, -20], [10, 6], [-10, -20], [-10, 6], [14, -36], [-14, 22]].map(([dx, dy]) => {
        const left = dx > 0 ? x + dx * k : x + dx * k - w;
        return [left, y + dy * k, left + w, y + dy * k + size];
      });
      const box = boxes.find(free) || boxes[0];
      taken.push(box);
      this.write(g, k, text, box[0], box[3] - 2 * k, off.startsWith("⚠") ? WARN : mark.colour);
    }
  }
}
