// How the lanes of the timeline are drawn: from three bytes a frame, which lanes.py makes.
// Joined with the other files here into one module by frame_canvas.py.

const EDITED = 1, SUSPECT = 2, STANCE = 4, PREDICTED = 8; // lanes.py
const UNKNOWN = 255, FULL = 250;
const RULER = 20; // CSS px of the line of frame numbers
const NAMES = 92; // CSS px of the names at the left

// A Timeline (timeline.js) as far as it is drawn: it has host, canvas, lanesPicture, bytes, first, n,
// view, lanes, laneHeight, plotWidth, stretch, point() and x(frame).
class Lanes {
  redraw() {
    if (this.dirty) return;
    this.dirty = true;
    requestAnimationFrame(() => {
      this.dirty = false;
      if (this.host.closed || !this.view || !this.canvas.width) return;
      if (this.stale) this.drawLanes();
      this.stale = false;
      this.drawOver();
    });
  }

  colours() {
    const style = getComputedStyle(this.host.root);
    const of = (name) => style.getPropertyValue(name).trim();
    return { ink: style.color, line: of("--line") || "#888", paper: of("--paper") || "#fff", brand: "#1e88e5" };
  }

  drawLanes() {
    const g = this.lanesPicture.getContext("2d");
    const k = window.devicePixelRatio || 1;
    const { ink, line, paper } = this.colours();
    this.theme = ink + paper;
    const { width, height } = this.lanesPicture;
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.fillStyle = paper;
    g.fillRect(0, 0, width, height);
    this.drawRuler(g, k, ink, line);
    const tall = this.laneHeight * k;
    this.lanes.forEach((lane, i) => {
      const top = (RULER + i * this.laneHeight) * k;
      this.drawName(g, k, lane, top, ink);
      this.drawLane(g, k, lane, i, { top, tall, ink });
      g.fillStyle = line;
      g.fillRect(0, Math.round(top + tall) - 1, width, 1);
    });
  }

  drawRuler(g, k, ink, line) {
    const rough = (this.view.frames * 80) / this.plotWidth;
    const ten = 10 ** Math.floor(Math.log10(Math.max(1, rough)));
    const step = [1, 2, 5, 10].map((m) => m * ten).find((s) => s >= rough) || 10 * ten;
    g.font = `${11 * k}px system-ui, sans-serif`;
    g.textBaseline = "middle";
    g.fillStyle = ink;
    g.fillText("frame", 4 * k, (RULER / 2) * k);
    for (let f = Math.ceil(this.view.from / step) * step; f < this.view.from + this.view.frames; f += step) {
      const x = this.x(f) * k;
      g.fillStyle = line;
      g.fillRect(Math.round(x), 0, 1, this.lanesPicture.height);
      g.fillStyle = ink;
      if (x + g.measureText(f).width + 6 * k < this.lanesPicture.width) g.fillText(f, x + 3 * k, (RULER / 2) * k);
    }
  }

  drawName(g, k, lane, top, ink) {
    g.fillStyle = lane.colour;
    g.fillRect(2 * k, top + 2 * k, 5 * k, (this.laneHeight - 4) * k);
    g.fillStyle = ink;
    g.font = `600 ${Math.min(12, this.laneHeight - 1) * k}px system-ui, sans-serif`;
    g.save();
    g.beginPath();
    g.rect(0, top, (NAMES - 4) * k, this.laneHeight * k);
    g.clip(); // a long name must not run into the lane
    g.direction = "ltr";
    g.fillText(lane.id || "(no name)", 11 * k, top + (this.laneHeight / 2) * k);
    g.restore();
  }

  // One column of device pixels at a time: the least sure of its frames counts.
  drawLane(g, k, lane, i, { top, tall, ink }) {
    const at = 3 * i * this.n;
    const right = this.lanesPicture.width;
    const perPx = this.view.frames / (this.plotWidth * k);
    let before = null; // the frame of the column before
    for (let x = Math.round(NAMES * k); x < right; x++) {
      const from = Math.floor(this.view.from + (x - NAMES * k) * perPx) - this.first;
      const to = Math.max(from + 1, Math.floor(this.view.from + (x + 1 - NAMES * k) * perPx) - this.first);
      let confidence = FULL, sd = 0, bits = 0, missing = 0, known = 0;
      for (let f = Math.max(0, from); f < Math.min(this.n, to); f++) {
        const b = at + 3 * f;
        if (this.bytes[b] === UNKNOWN) missing++;
        else { confidence = Math.min(confidence, this.bytes[b]); known++; }
        if (this.bytes[b + 1] !== UNKNOWN) sd = Math.max(sd, this.bytes[b + 1]);
        bits |= this.bytes[b + 2];
      }
      if (known) {
        const high = Math.max(1, Math.round(((tall - 2 * k) * confidence) / FULL));
        g.globalAlpha = bits & PREDICTED ? 0.3 : missing ? 0.45 : 0.75;
        g.fillStyle = lane.colour;
        g.fillRect(x, top + tall - 1 - high, 1, high);
        g.globalAlpha = 1;
      } else if (missing) {
        g.fillStyle = ink;
        if (x % 4 === 0) g.fillRect(x, top + tall / 2, 2, 1); // dotted: nothing there
      }
      if (sd) {
        g.fillStyle = ink;
        g.globalAlpha = 0.55;
        g.fillRect(x, top + tall - 2 - Math.round(((tall - 4 * k) * sd) / FULL), 1, Math.ceil(k));
        g.globalAlpha = 1;
      }
      if (bits & STANCE) {
        g.fillStyle = ink;
        g.fillRect(x, top + tall - 1 - 2 * k, 1, 2 * k);
      }
      if (bits & SUSPECT) {
        g.fillStyle = "#d32f2f";
        g.fillRect(x, top + 1, Math.max(1, Math.round(1.5 * k)), 4 * k);
      }
      if (bits & EDITED && from !== before) {
        g.fillStyle = ink; // a line, however wide its frame is
        g.fillRect(x, top + 1, Math.ceil(k), tall - 2);
      }
      before = from;
    }
  }

  drawOver() {
    const g = this.canvas.getContext("2d");
    const k = window.devicePixelRatio || 1;
    const { ink, paper, brand } = this.colours();
    if (ink + paper !== this.theme) this.drawLanes();
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.drawImage(this.lanesPicture, 0, 0);
    const { frames } = this.host;
    const chosen = this.lanes.findIndex((lane) => lane.id === this.point());
    const lane = (i) => [(RULER + i * this.laneHeight) * k, this.laneHeight * k];
    if (chosen >= 0) {
      const [top, tall] = lane(chosen);
      g.strokeStyle = brand;
      g.lineWidth = 1.5 * k;
      g.strokeRect(k, top + 0.5 * k, this.canvas.width - 2 * k, tall - 1.5 * k);
    }
    const own = this.stretch;
    const i = own ? this.lanes.findIndex((one) => one.id === own.point) : -1;
    g.save();
    g.beginPath();
    g.rect(NAMES * k, 0, this.canvas.width, this.canvas.height);
    g.clip();
    if (i >= 0) {
      const [x0, x1] = [this.x(own.first) * k, this.x(own.last + 1) * k];
      const [top, tall] = lane(i);
      g.fillStyle = "rgba(255, 193, 7, 0.45)";
      g.fillRect(x0, top, x1 - x0, tall);
      g.fillRect(x0, 0, x1 - x0, RULER * k);
      g.fillStyle = ink;
      for (const x of [x0, x1]) g.fillRect(Math.round(x - k), top, 2 * k, tall);
    }
    this.drawn = frames.shown ?? frames.want;
    const x = this.x(this.drawn + 0.5) * k;
    g.fillStyle = brand;
    g.fillRect(Math.round(x - 0.75 * k), 0, Math.round(1.5 * k), this.canvas.height);
    g.beginPath();
    g.moveTo(x - 6 * k, 0);
    g.lineTo(x + 6 * k, 0);
    g.lineTo(x, 9 * k);
    g.fill();
    g.restore();
    const [first, last] = frames.span;
    const told = { "aria-valuemin": first, "aria-valuemax": last, "aria-valuenow": this.drawn };
    for (const [name, value] of Object.entries(told)) this.canvas.setAttribute(name, value);
  }
}
