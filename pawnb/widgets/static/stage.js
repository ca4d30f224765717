// One view of a trial: its picture, zoom, and the mouse; what is drawn over it is in marks.js.
//
// Image coordinates: u right, v down, (0, 0) is the centre of the top-left pixel.
// Canvas coordinates are device pixels: x = (u + 0.5) * scale + tx, likewise y.
// Joined with the other files here into one module by frame_canvas.py.

const GRAB_PX = 14; // how near, in CSS pixels, the mouse must be to take a point
const ON_MARK_PX = 8; // the same while a click would place another point: on its ring
const CLICK_PX = 4; // a press that moves further than this is a pan, not a click
const MAX_ZOOM = 40; // device pixels per image pixel

class Stage extends Marks {
  // `host` is told what the mouse does: edit, select, released, rezoomed, redraw, focus, takesWheel; it knows
  // what a click would place (asked), where the other views put that (guideOf), and whether Python hears it (connection).
  constructor(spec, host) {
    super();
    Object.assign(this, { name: spec.name, W: spec.width, H: spec.height, host });
    this.bitmap = null;
    this.overlay = {};
    this.stick = null; // a stick animal that can be bent, see stick.js
    this.tint = null; // a translucent picture over the view
    this.drag = null;
    this.live = null; // what other views say of the point in the hand, or this one of another's
    this.over = null; // the point under the mouse
    this.mouse = null;
    this.aim = null; // where the mouse is, while a click there would place a point
    this.zoom = { scale: 1, tx: 0, ty: 0 };
    this.fitted = true;
    this.el = document.createElement("div");
    this.el.className = "pawnb-view";
    this.el.dataset.view = spec.name;
    this.head = document.createElement("div");
    this.head.className = "pawnb-head";
    // a screen reader says whose buttons these are: every view has the same
    this.head.role = "group";
    this.head.ariaLabel = `view ${spec.name}`;
    this.frame = document.createElement("div");
    this.frame.className = "pawnb-frame";
    this.image = document.createElement("canvas");
    this.image.className = "pawnb-image";
    this.marks = document.createElement("canvas");
    this.marks.className = "pawnb-marks";
    this.frame.append(this.image, this.marks);
    this.el.append(this.head, this.frame);
    this.listen();
  }

  // --- size and zoom ---------------------------------------------------------------

  // Lay the picture out `width` CSS pixels wide; the part that was looked at stays in view.
  resize(width) {
    const dpr = window.devicePixelRatio || 1;
    const w = Math.max(1, Math.round(width * dpr));
    const h = Math.max(1, Math.round((w * this.H) / this.W));
    if (this.image.width === w && this.image.height === h) return;
    const factor = w / this.image.width;
    for (const canvas of [this.image, this.marks]) {
      canvas.width = w;
      canvas.height = h;
      canvas.style.width = `${w / dpr}px`;
      canvas.style.height = `${h / dpr}px`;
    }
    this.frame.style.width = `${w / dpr}px`;
    this.head.style.maxWidth = `${w / dpr}px`; // many points take another line
    const z = this.zoom;
    if (this.fitted) this.fit();
    else this.setZoom(z.scale * factor, z.tx * factor, z.ty * factor);
  }

  get fitScale() {
    return this.image.width / this.W;
  }

  fit() {
    this.setZoom(this.fitScale, 0, 0);
  }

  // The picture always covers the canvas, so it cannot get lost outside.
  setZoom(scale, tx, ty) {
    scale = Math.min(Math.max(scale, this.fitScale), Math.max(MAX_ZOOM, this.fitScale));
    const clamp = (t, size, canvas) => Math.min(0, Math.max(t, canvas - size * scale));
    this.zoom = {
      scale,
      tx: clamp(tx, this.W, this.image.width),
      ty: clamp(ty, this.H, this.image.height),
    };
    this.fitted = scale <= this.fitScale * 1.0001;
    this.host.rezoomed();
  }

  zoomAbout(x, y, factor) {
    const { scale, tx, ty } = this.zoom;
    const to = Math.min(Math.max(scale * factor, this.fitScale), MAX_ZOOM);
    const k = to / scale;
    this.setZoom(to, x - (x - tx) * k, y - (y - ty) * k);
  }

  zoomToRectangle(x0, y0, x1, y1) {
    const w = Math.abs(x1 - x0);
    const h = Math.abs(y1 - y0);
    if (w < 5 || h < 5) return;
    const { scale, tx, ty } = this.zoom;
    const factor = Math.min(this.image.width / w, this.image.height / h);
    const to = Math.min(scale * factor, MAX_ZOOM);
    const u = ((x0 + x1) / 2 - tx) / scale;
    const v = ((y0 + y1) / 2 - ty) / scale;
    this.setZoom(to, this.image.width / 2 - u * to, this.image.height / 2 - v * to);
  }

  // Show `width` px of the view about (u, v).
  lookAt(u, v, width) {
    const to = Math.min(this.image.width / width, MAX_ZOOM);
    this.setZoom(to, this.image.width / 2 - (u + 0.5) * to, this.image.height / 2 - (v + 0.5) * to);
  }

  // How many times smaller the picture may be before it can be seen: 1 to 4, in quarters, so that
  // hardly more pixels are encoded, sent and decoded than are shown.
  get shrink() {
    if (this.host.closer && this.host.closer.loupe) return 1;
    const merged = Math.floor(4 / this.zoom.scale + 1e-6) / 4;
    return Math.max(1, Math.min(4, merged));
  }

  toCanvas(u, v) {
    const { scale, tx, ty } = this.zoom;
    return [(u + 0.5) * scale + tx, (v + 0.5) * scale + ty];
  }

  // Where the mouse is: canvas pixels x, y and image pixels u, v.
  locate(event) {
    const box = this.marks.getBoundingClientRect();
    const x = ((event.clientX - box.left) * this.marks.width) / box.width;
    const y = ((event.clientY - box.top) * this.marks.height) / box.height;
    const { scale, tx, ty } = this.zoom;
    return { x, y, u: (x - tx) / scale - 0.5, v: (y - ty) / scale - 0.5 };
  }

  inside({ u, v }) {
    return u >= -0.5 && v >= -0.5 && u < this.W - 0.5 && v < this.H - 0.5;
  }

  // Whether the mouse is outside of what is shown of the view, by more than a hand that overshoots.
  isAway({ x, y }) {
    const over = GRAB_PX * (window.devicePixelRatio || 1);
    const { width, height } = this.marks;
    return x < -over || y < -over || x > width + over || y > height + over;
  }

  setOverlay(overlay) {
    this.overlay = overlay;
    this.over = null;
    this.setTint(overlay.tint);
    if (this.stick && this.stick.start) return; // a stick animal in the hand stays there
    this.stick = overlay.stick ? new Stick(overlay.stick) : null;
    // a point in the hand stays there
    const held = this.drag && this.drag.kind === "point" ? this.drag.point : null;
    const same = held && (overlay.points || []).find((point) => point.id === held.id);
    if (same) this.drag.point = Object.assign(same, { u: held.u, v: held.v });
  }

  setTint(tint) {
    if ((tint && tint.url) === (this.tint && this.tint.url)) return;
    this.tint = tint ? { ...tint, image: new Image() } : null;
    if (!tint) return;
    this.tint.image.onload = () => this.host.redraw();
    this.tint.image.src = tint.url;
  }

  // The point that a press here takes. While one is asked for, a click near another places the
  // one asked for: only the ring itself takes that other.
  nearest({ x, y }) {
    let best = null;
    const reach = this.host.asked(this) ? ON_MARK_PX : GRAB_PX;
    let least = reach * (window.devicePixelRatio || 1);
    const handles = this.stick ? this.stick.handles() : [];
    for (const point of [...(this.overlay.points || []), ...handles]) {
      const [px, py] = this.toCanvas(point.u, point.v);
      const distance = Math.hypot(px - x, py - y);
      if (distance < least) [least, best] = [distance, point];
    }
    return best;
  }

  // --- mouse -----------------------------------------------------------------------

  listen() {
    const on = (type, handler, options) => this.marks.addEventListener(type, handler, options);
    on("wheel", (e) => {
      if (!this.host.takesWheel(e)) return; // the page scrolls
      e.preventDefault();
      const { x, y } = this.locate(e);
      const lines = e.deltaMode === 1 ? 30 : 1; // Firefox counts lines, not pixels
      this.zoomAbout(x, y, Math.exp(-e.deltaY * lines * 0.0015));
      this.host.closer.zoomed(this);
    }, { passive: false });
    on("contextmenu", (e) => { e.preventDefault(); e.stopPropagation(); });
    on("pointerdown", (e) => this.press(e));
    on("pointermove", (e) => this.move(e));
    on("pointerup", (e) => this.release(e));
    on("pointercancel", () => this.cancel());
    on("pointerleave", () => { this.over = this.aim = this.mouse = null; this.host.redraw(); });
  }

  press(e) {
    this.host.focus();
    if (this.drag) return;
    const at = this.locate(e);
    const point = this.nearest(at);
    if (e.button === 2) {
      if (point) this.host.edit({ what: "hide", view: this.name, point: point.id });
      return;
    }
    this.marks.setPointerCapture(e.pointerId);
    const start = { ...at, x1: at.x, y1: at.y, pointer: e.pointerId };
    if (e.button === 1 || e.altKey) this.drag = { ...start, kind: "pan" };
    else if (e.button !== 0) return;
    else if (e.shiftKey || this.host.rectangle) this.drag = { ...start, kind: "rectangle" };
    else if (point && !this.host.connection.down) {
      const asked = this.host.asked(this);
      if (point.kind) this.stick.grab();
      if (!asked && (!point.kind || point.chip)) this.host.select(this, point.chip || point.id);
      const off = { du: point.u - at.u, dv: point.v - at.v };
      this.drag = { ...start, ...off, kind: "point", point, was: [point.u, point.v], asked };
    } else this.drag = { ...start, kind: "press" };
    e.preventDefault(); // no text selection, no autoscroll
  }

  move(e) {
    const at = (this.mouse = this.locate(e));
    const drag = this.drag;
    if (this.host.closer.loupe) this.host.redraw();
    if (!drag) {
      const over = this.nearest(at);
      const asked = this.host.asked(this);
      const guide = asked && (this.guides[asked] || this.host.guideOf(this, asked));
      this.aim = guide ? { id: asked, u: at.u, v: at.v, guide } : null;
      if (this.aim || (over && over.id) !== (this.over && this.over.id)) this.host.redraw();
      this.over = over;
      this.marks.style.cursor = over ? "grab" : "crosshair";
      return;
    }
    const far = Math.hypot(at.x - drag.x, at.y - drag.y);
    if (far > CLICK_PX * (window.devicePixelRatio || 1)) {
      drag.moved = true;
      if (drag.kind === "press") drag.kind = "pan";
    }
    if (drag.kind === "pan") {
      const { scale, tx, ty } = this.zoom;
      this.setZoom(scale, tx + at.x - drag.x1, ty + at.y - drag.y1);
    } else if (drag.kind === "point" && drag.moved) {
      const { du, dv, was } = drag;
      const to = [
        Math.min(Math.max(at.u + du, -0.49), this.W - 0.51),
        Math.min(Math.max(at.v + dv, -0.49), this.H - 0.51),
      ];
      drag.away = !drag.point.kind && !drag.point.clamped && this.isAway(at);
      [drag.point.u, drag.point.v] = drag.away ? was : to;
      drag.whole = !e.ctrlKey && !e.metaKey;
      if (drag.point.kind) this.stick.drag(drag.point.id, drag.point.u, drag.point.v, drag.whole);
    }
    [drag.x1, drag.y1] = [at.x, at.y];
    const grip = drag.away ? "not-allowed" : "grabbing";
    this.marks.style.cursor = { point: grip, pan: "move" }[drag.kind] || "crosshair";
    this.host.redraw();
  }

  release(e) {
    const drag = this.drag;
    this.drag = null;
    if (!drag) return;
    const bent = this.stick && this.stick.start;
    if (drag.kind === "point" && drag.point.kind) this.stick.release();
    const at = this.locate(e);
    if (drag.kind === "rectangle") {
      this.zoomToRectangle(drag.x, drag.y, at.x, at.y);
      this.host.closer.zoomed(this);
      this.host.setRectangle(false);
    } else if (drag.away) {
      // let go outside of the picture: it has gone back to where it was
    } else if (drag.kind === "point" && drag.moved) {
      const { id, u, v } = drag.point;
      const takeBack = () => {
        [drag.point.u, drag.point.v] = drag.was;
        if (bent && this.stick) this.stick.spec = bent;
      };
      const moved = { what: "moved", view: this.name, point: id, u, v, whole: drag.whole };
      this.host.edit(moved, takeBack);
    } else if ((drag.kind === "press" || drag.asked) && this.inside(drag)) {
      this.host.edit({ what: "click", view: this.name, u: drag.u, v: drag.v });
    }
    this.host.released();
  }

  // Esc: the point goes back to where it was.
  cancel() {
    const drag = this.drag;
    if (!drag) return false;
    this.drag = null;
    if (drag.kind === "point") [drag.point.u, drag.point.v] = drag.was;
    if (drag.kind === "point" && drag.point.kind) this.stick.restore();
    if (this.marks.hasPointerCapture(drag.pointer)) this.marks.releasePointerCapture(drag.pointer);
    this.host.released();
    return true;
  }
}
