// The timeline: a lane for each point (drawn by lanes.js), the scrubber, and the stretch.
// Joined with the other files here into one module by frame_canvas.py.
//
// kernel -> browser: {type: "lanes", first, n, begin, data, sd_full}   browser -> kernel: {type: "lanes"}
// browser -> kernel: {type: "edit", what: "stretch", action, point, other?, view?, stretch?}

const EDGE_PX = 5; // how near, in CSS px, the mouse must be to take an end or the line of the frame
const LEAST_FRAMES = 20; // as far as it can be zoomed in

class Timeline extends Lanes {
  // `host` is the Canvas: model, frames, connection, selected, go, edit, focus, takesWheel, choose.
  constructor(host) {
    super();
    this.host = host;
    this.model = host.model;
    this.bytes = null; // of all lanes, one after the other
    this.first = host.frames.span[0];
    this.n = 0;
    this.view = null; // first frame and number of frames that are shown
    this.drag = null;
    this.width = 0; // of the canvas, CSS px
    this.el = element("div", "pawnb-timeline");
    this.bar = new StretchBar(this);
    this.canvas = element("canvas", "pawnb-lanes", { tabIndex: -1 });
    this.canvas.setAttribute("role", "slider");
    this.canvas.setAttribute("aria-label", "frame, on the timeline");
    this.canvas.title = "";
    this.lanesPicture = document.createElement("canvas"); // the lanes without what moves over them
    this.el.append(this.bar.el, this.canvas);
    this.listen();
  }

  get lanes() {
    return this.model.get("lanes");
  }

  get laneHeight() {
    return Math.max(9, Math.min(20, Math.floor(170 / this.lanes.length)));
  }

  // The stretch that is chosen: {point, first, last}, or null.
  get stretch() {
    const [point, first, last] = this.model.get("stretch") || [];
    return point === undefined ? null : { point, first, last };
  }

  choose(point, a, b) {
    const [first, last] = this.host.frames.span;
    const within = (frame) => Math.max(first, Math.min(last, Math.round(frame)));
    const ends = [within(a), within(b)].sort((x, y) => x - y);
    this.model.set("stretch", [point, ...ends]);
    this.chosen();
  }

  clear() {
    if (!this.stretch) return false;
    this.model.set("stretch", []);
    this.keep();
    return true;
  }

  // Python learns which stretch is chosen once it is.
  keep() {
    if (!this.host.connection.down) this.model.save_changes();
    this.chosen();
  }

  // I and O: an end of the stretch in the frame that is shown.
  mark(isEnd) {
    const { want } = this.host.frames;
    const point = this.point();
    if (point === null) return;
    const had = this.stretch && this.stretch.point === point ? this.stretch : null;
    const [first, last] = had ? [had.first, had.last] : [want, want];
    if (isEnd) this.choose(point, Math.min(first, want), want);
    else this.choose(point, want, Math.max(last, want));
    this.keep();
  }

  // The point that is meant: that of the stretch, else the one chosen in the pictures.
  point() {
    if (this.stretch) return this.stretch.point;
    const [, id] = this.host.selected || [];
    return this.lanes.some((lane) => lane.id === id) ? id : null;
  }

  received({ first, n, begin, data, sd_full: sdFull }) {
    const part = fromBase64(data);
    const count = this.lanes.length;
    const frames = part.length / (3 * count);
    if (!this.bytes || this.n !== n || this.bytes.length !== 3 * count * n) {
      if (frames !== n) return this.ask(); // a part of lanes that are not here
      this.bytes = new Uint8Array(3 * count * n);
      Object.assign(this, { first, n });
      this.view = { from: first, frames: n };
    }
    this.sdFull = sdFull;
    for (let lane = 0; lane < count; lane++)
      this.bytes.set(part.subarray(3 * lane * frames, 3 * (lane + 1) * frames), 3 * (lane * n + begin));
    this.stale = true;
    this.bar.show();
    this.redraw();
  }

  // A point or a stretch was chosen, here or elsewhere.
  chosen() {
    this.bar.show();
    this.redraw();
  }

  ask() {
    this.host.connection.send({ type: "lanes" });
  }

  // --- where things are --------------------------------------------------------------------

  resize(width) {
    const dpr = window.devicePixelRatio || 1;
    const height = RULER + this.lanes.length * this.laneHeight + 1;
    const [w, h] = [Math.round(width * dpr), Math.round(height * dpr)];
    if (this.canvas.width === w && this.canvas.height === h) return;
    for (const canvas of [this.canvas, this.lanesPicture]) [canvas.width, canvas.height] = [w, h];
    Object.assign(this.canvas.style, { width: `${w / dpr}px`, height: `${h / dpr}px` });
    this.width = w / dpr;
    this.stale = true;
    this.redraw();
  }

  get plotWidth() {
    // not asked of the page, where it is 0 while that is hidden or changes its theme
    return this.width - NAMES;
  }

  // Left edge of a frame, CSS px.
  x(frame) {
    return NAMES + ((frame - this.view.from) * this.plotWidth) / this.view.frames;
  }

  locate(e) {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [e.clientX - box.left, e.clientY - box.top];
    const frame = Math.floor(this.view.from + ((x - NAMES) * this.view.frames) / this.plotWidth);
    const lane = this.lanes[Math.floor((y - RULER) / this.laneHeight)];
    return { x, y, frame, lane: y < RULER ? null : lane, named: x < NAMES };
  }

  setView(from, frames) {
    frames = Math.min(this.n, Math.max(Math.min(LEAST_FRAMES, this.n), frames));
    const latest = this.first + this.n - frames;
    this.view = { from: Math.max(this.first, Math.min(latest, from)), frames };
    this.stale = true;
    this.redraw();
  }

  // --- the mouse ---------------------------------------------------------------------------

  listen() {
    const on = (type, handler, options) => this.canvas.addEventListener(type, handler, options);
    on("wheel", (e) => {
      if (!this.view || !this.host.takesWheel(e)) return; // the page scrolls
      e.preventDefault();
      const { from, frames } = this.view;
      const lines = e.deltaMode === 1 ? 30 : 1;
      if (e.shiftKey || Math.abs(e.deltaX) > Math.abs(e.deltaY)) {
        const by = (e.deltaX || e.deltaY) * lines;
        this.setView(from + (by * frames) / this.plotWidth, frames);
        return;
      }
      const at = from + ((this.locate(e).x - NAMES) * frames) / this.plotWidth;
      const to = Math.min(this.n, Math.max(LEAST_FRAMES, frames * Math.exp(e.deltaY * lines * 0.002)));
      this.setView(at - ((at - from) * to) / frames, to);
    }, { passive: false });
    on("dblclick", () => this.view && this.setView(this.first, this.n));
    on("contextmenu", (e) => { e.preventDefault(); e.stopPropagation(); });
    on("pointerdown", (e) => this.press(e));
    on("pointermove", (e) => this.move(e));
    on("pointerup", (e) => this.release(e));
    on("pointercancel", () => { this.drag = null; });
  }

  // Which end of the stretch a press takes: the other one stays.
  takenEnd({ x, lane }) {
    const own = this.stretch;
    if (!own || !lane || lane.id !== own.point) return null;
    if (Math.abs(x - this.x(own.first)) < EDGE_PX) return own.last;
    if (Math.abs(x - this.x(own.last + 1)) < EDGE_PX) return own.first;
    return null;
  }

  press(e) {
    this.host.focus();
    if (!this.view || e.button !== 0) return;
    e.preventDefault();
    this.canvas.setPointerCapture(e.pointerId);
    const at = this.locate(e);
    const other = this.takenEnd(at);
    if (other !== null) this.drag = { kind: "stretch", point: at.lane.id, other, x: at.x, moved: true };
    else if (at.lane && !at.named) this.drag = { kind: "stretch", point: at.lane.id, other: at.frame, x: at.x };
    else if (at.lane) this.drag = { kind: "name", point: at.lane.id };
    else {
      this.drag = { kind: "scrub" };
      this.host.go(at.frame);
    }
  }

  move(e) {
    if (!this.view) return;
    const at = this.locate(e);
    const { drag } = this;
    if (!drag) {
      this.canvas.style.cursor = !at.lane || this.takenEnd(at) !== null ? "ew-resize" : "crosshair";
      this.canvas.title = this.words(at);
      return;
    }
    if (drag.kind === "scrub") this.host.go(at.frame);
    if (drag.kind !== "stretch") return;
    drag.moved ||= Math.abs(at.x - drag.x) > CLICK_PX;
    if (drag.moved) this.choose(drag.point, drag.other, at.frame);
  }

  release(e) {
    const { drag } = this;
    this.drag = null;
    if (!drag || drag.kind === "scrub") return;
    if (drag.moved) this.keep();
    else {
      if (drag.kind === "stretch") this.host.go(this.locate(e).frame);
      this.host.choose(drag.point);
    }
  }

  // What a lane says of the frame under the mouse.
  words({ lane, frame, named }) {
    if (!lane || named) return lane ? lane.id : "";
    const i = frame - this.first;
    if (i < 0 || i >= this.n) return "";
    const k = 3 * (this.lanes.indexOf(lane) * this.n + i);
    const [confidence, sd, bits] = this.bytes.subarray(k, k + 3);
    const parts = [confidence === UNKNOWN ? "missing" : `confidence ${(confidence / FULL).toFixed(2)}`];
    const [before, after] = this.model.get("thin_line");
    const size = `${sd >= FULL ? "≥ " : ""}${((sd * this.sdFull) / FULL).toPrecision(2)}`;
    if (sd !== UNKNOWN) parts.push(`${before} ${size}${after}`);
    for (const [bit, word] of [[PREDICTED, "predicted"], [EDITED, "placed by hand"], [SUSPECT, "doubtful"], [STANCE, "stance"]])
      if (bits & bit) parts.push(word);
    return `${lane.id}, frame ${frame}: ${parts.join(", ")}`;
  }

  // The frame stays in view: the timeline turns over a page where it leaves.
  follow() {
    const { want, shown } = this.host.frames;
    if (this.view && !this.drag) {
      const { from, frames } = this.view;
      if (want < from || want >= from + frames) this.setView(want - frames * 0.1, frames);
    }
    if (this.drawn !== (shown ?? want)) this.redraw();
  }
}
