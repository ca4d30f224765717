// A stick animal over the picture: drawn, and bent while a handle is dragged.
//
// What a drag does is decided by pawnb/core/pose/handles.py; the same rules stand here, so that
// what is seen while dragging is what is kept afterwards. Change both together.
// Joined with the other files here into one module by frame_canvas.py.

const REACH_STEPS = 40;
const REACH_DAMPING = 0.004; // of the leg's squared length
const REACH_STIFF = 0.05; // how freely a joint turns further beyond its range
const BEYOND = "#ff3b30"; // a joint beyond its range
const BODY = "#ffffff";

const radians = (degrees) => (degrees * Math.PI) / 180;
const degrees = (angle) => (angle * 180) / Math.PI;

class Stick {
  constructor(spec) {
    this.spec = spec;
    this.start = null; // as it was when the drag began
  }

  // --- where things are ------------------------------------------------------------------

  onBody(x, y) {
    const { xy, heading, scale } = this.spec;
    const [cos, sin] = [Math.cos(radians(heading)), Math.sin(radians(heading))];
    return [xy[0] + scale * (x * cos - y * sin), xy[1] + scale * (x * sin + y * cos)];
  }

  // Joints and tip of a leg, px of the view.
  places(leg, angles = leg.angles) {
    const out = [this.onBody(...leg.attach)];
    let forwards = 0;
    leg.lengths.forEach((length, i) => {
      forwards += angles[i];
      const turn = radians(this.spec.heading + leg.side * (90 - forwards));
      const [u, v] = out[i];
      const step = this.spec.scale * length;
      out.push([u + step * Math.cos(turn), v + step * Math.sin(turn)]);
    });
    return out;
  }

  // What can be dragged: {id, u, v, colour, chip, kind}.
  handles() {
    const { span, front, legs } = this.spec;
    const make = (id, [u, v], kind, colour, chip) => ({ id, u, v, kind, colour, chip });
    const out = [make("body", this.onBody(0, 0), "body", BODY)];
    out.push(make("heading", this.onBody(1.5 * front, 0), "heading", BODY));
    const aside = radians(this.spec.span_at);
    const spanAt = this.onBody((span / 2) * Math.cos(aside), (span / 2) * Math.sin(aside));
    out.push(make("span", spanAt, "span", BODY));
    for (const leg of legs) {
      if (leg.missing) continue;
      const places = this.places(leg);
      leg.joints.forEach((joint, k) => {
        if (k && leg.free[k])
          out.push(make(`${leg.name}.${joint}`, places[k], "joint", leg.colour, leg.name));
      });
      out.push(make(leg.name, places[leg.lengths.length], "tip", leg.colour, leg.name));
    }
    return out;
  }

  // --- dragging --------------------------------------------------------------------------

  grab() {
    this.start = JSON.parse(JSON.stringify(this.spec));
  }

  drag(id, u, v, whole) {
    this.spec = JSON.parse(JSON.stringify(this.start));
    const { spec } = this;
    const [du, dv] = [u - spec.xy[0], v - spec.xy[1]];
    if (id === "body") spec.xy = [u, v];
    else if (id === "heading") spec.heading = degrees(Math.atan2(dv, du));
    else if (id === "span") spec.scale = Math.max((2 * Math.hypot(du, dv)) / spec.span, 1e-3);
    else {
      const leg = spec.legs.find(({ name }) => name === id.split(".")[0]);
      const tip = id === leg.name;
      const at = tip ? leg.lengths.length : leg.joints.indexOf(id.split(".")[1]);
      leg.angles = tip && whole ? this.reach(leg, u, v) : this.turn(leg, at, u, v);
      spec.leg = leg.name;
    }
  }

  release() {
    this.start = null;
  }

  restore() {
    if (this.start) this.spec = this.start;
    this.start = null;
  }

  // handles.turn_joint
  turn(leg, at, u, v) {
    const angles = [...leg.angles];
    let j = at - 1;
    while (j >= 0 && !leg.free[j]) j--;
    if (j < 0) return angles;
    const places = this.places(leg);
    const [u0, v0] = places[j];
    const was = Math.atan2(places[at][1] - v0, places[at][0] - u0);
    const by = degrees(Math.atan2(v - v0, u - u0) - was);
    const angle = angles[j] - leg.side * by + 180;
    angles[j] = angle - 360 * Math.floor(angle / 360) - 180;
    return angles;
  }

  // handles.reach_tip: damped least squares, joints reluctant beyond their range
  reach(leg, u, v) {
    const angles = [...leg.angles];
    const n = leg.lengths.length;
    const size = this.spec.scale * leg.lengths.reduce((a, b) => a + b, 0);
    const [ru, rv] = this.places(leg)[0];
    // out of reach the leg is straight: steps towards the place itself never settle
    const within = Math.min(1, size / Math.max(Math.hypot(u - ru, v - rv), 1e-9));
    [u, v] = [ru + within * (u - ru), rv + within * (v - rv)];
    const freedom = leg.half.map((half, j) => (leg.free[j] ? half / 60 + 0.05 : 0));
    for (let step = 0; step < REACH_STEPS; step++) {
      const places = this.places(leg, angles);
      const [tu, tv] = places[n];
      let [mu, mv] = [u - tu, v - tv];
      const off = Math.hypot(mu, mv);
      if (off < 0.01) break;
      const cut = Math.min(1, (0.25 * size) / off);
      [mu, mv] = [mu * cut, mv * cut];
      const across = places.slice(0, n).map(([pu, pv]) => [leg.side * (tv - pv), -leg.side * (tu - pu)]);
      let [a, b, d] = [REACH_DAMPING * size ** 2, 0, REACH_DAMPING * size ** 2];
      const weight = across.map(([x, y], j) => {
        const turned = angles[j] - leg.natural[j];
        const beyond = Math.abs(turned) > leg.half[j] && (x * mu + y * mv) * turned > 0;
        const w = freedom[j] * (beyond ? REACH_STIFF : 1);
        a += w * x * x;
        b += w * x * y;
        d += w * y * y;
        return w;
      });
      const det = a * d - b * b;
      const [pu, pv] = [(d * mu - b * mv) / det, (a * mv - b * mu) / det];
      across.forEach(([x, y], j) => { angles[j] += degrees(weight[j] * (x * pu + y * pv)); });
    }
    return angles;
  }

  // --- drawing ---------------------------------------------------------------------------

  // `held`: the handle in the hand, `over`: the one under the mouse.
  draw(g, k, stage, held, over) {
    const { spec } = this;
    const dash = spec.dashed ? [7 * k, 5 * k] : [];
    this.drawBody(g, k, stage, dash);
    for (const leg of spec.legs) if (!leg.missing) this.drawLeg(g, k, stage, leg, dash);
    if (held) this.drawRanges(g, k, stage, held);
    for (const handle of this.handles()) {
      const near = (over && over.id === handle.id) || (held && held.id === handle.id);
      this.drawHandle(g, k, stage, handle, near);
    }
  }

  path(g, stage, points, close = false) {
    g.beginPath();
    points.forEach(([u, v], i) => g[i ? "lineTo" : "moveTo"](...stage.toCanvas(u, v)));
    if (close) g.closePath();
  }

  drawBody(g, k, stage, dash) {
    g.setLineDash(dash);
    for (const { centre, length, width } of this.spec.body) {
      const round = [...Array(48).keys()].map((i) => {
        const turn = (2 * Math.PI * i) / 48;
        return this.onBody(
          centre[0] + (length / 2) * Math.cos(turn),
          centre[1] + (width / 2) * Math.sin(turn),
        );
      });
      stage.outlined(g, k, 1.4, BODY, () => { this.path(g, stage, round, true); g.stroke(); }, 1.4);
    }
    const ends = [this.onBody(0, 0), this.onBody(1.5 * this.spec.front, 0)];
    stage.outlined(g, k, 1.4, BODY, () => { this.path(g, stage, ends); g.stroke(); }, 1.4);
    g.setLineDash([]);
  }

  // A segment whose joint is beyond its range is red with white dashes, and so is what cannot
  // turn further out.
  drawLeg(g, k, stage, leg, dash) {
    const places = this.places(leg);
    g.setLineDash(dash);
    const width = leg.name === this.spec.leg ? 2.6 : 1.6;
    let beyond = false;
    for (let i = 0; i < leg.lengths.length; i++) {
      if (leg.free[i]) beyond = Math.abs(leg.angles[i] - leg.natural[i]) > leg.half[i] + 0.5;
      const line = () => { this.path(g, stage, [places[i], places[i + 1]]); g.stroke(); };
      stage.outlined(g, k, beyond ? width + 0.8 : width, beyond ? BEYOND : leg.colour, line, 1.4);
      if (!beyond) continue;
      g.setLineDash([3 * k, 5 * k]);
      g.lineWidth = 1.2 * k;
      g.strokeStyle = "#fff";
      line();
      g.setLineDash(dash);
    }
    g.setLineDash([]);
  }

  // The range of each joint that this handle turns, as a wedge at the joint.
  drawRanges(g, k, stage, { id, kind }) {
    if (kind !== "joint" && kind !== "tip") return;
    const leg = this.spec.legs.find(({ name }) => name === id.split(".")[0]);
    const places = this.places(leg);
    const at = kind === "tip" ? leg.lengths.length : leg.joints.indexOf(id.split(".")[1]);
    let shown = leg.free.map((free, j) => free && j < at);
    if (kind === "joint") shown = shown.map((on, j) => on && !shown.slice(j + 1).some(Boolean));
    let forwards = 0;
    leg.angles.forEach((angle, j) => {
      const before = forwards;
      forwards += angle;
      if (!shown[j]) return;
      const [x, y] = stage.toCanvas(...places[j]);
      const scale = stage.zoom.scale * this.spec.scale;
      const r = Math.max(22 * k, 0.9 * scale * leg.lengths[j]);
      const direction = (forward) => radians(this.spec.heading + leg.side * (90 - before - forward));
      const ends = [-1, 1].map((s) => direction(leg.natural[j] + s * leg.half[j]));
      const [from, to] = [Math.min(...ends), Math.max(...ends)];
      const beyond = Math.abs(angle - leg.natural[j]) > leg.half[j] + 0.5;
      const colour = beyond ? BEYOND : leg.colour;
      g.beginPath();
      g.moveTo(x, y);
      g.arc(x, y, r, from, to);
      g.closePath();
      g.globalAlpha = 0.28;
      g.fillStyle = colour;
      g.fill();
      g.globalAlpha = 1;
      stage.outlined(g, k, 1.2, colour, () => {
        g.beginPath();
        g.arc(x, y, r, from, to);
        g.stroke();
      }, 1.2);
    });
  }

  drawHandle(g, k, stage, { u, v, kind, colour, chip }, near) {
    const [x, y] = stage.toCanvas(u, v);
    const chosen = chip === this.spec.leg;
    const size = { body: 6, heading: 5.5, span: 5.5, joint: chosen ? 4 : 3, tip: chosen ? 6 : 5 }[kind];
    const r = (near ? size + 2 : size) * k;
    g.beginPath();
    if (kind === "span" || kind === "heading") g.rect(x - r, y - r, 2 * r, 2 * r);
    else g.arc(x, y, r, 0, 2 * Math.PI);
    g.fillStyle = kind === "joint" ? colour : "rgba(0, 0, 0, 0.45)";
    g.fill();
    g.lineWidth = (kind === "joint" ? 1.2 : 3.4) * k;
    g.strokeStyle = rim(colour, 0.7);
    g.stroke();
    if (kind !== "joint") {
      g.lineWidth = 1.8 * k;
      g.strokeStyle = colour;
      g.stroke();
    }
    if (near) {
      g.lineWidth = 1.2 * k;
      g.strokeStyle = "#fff";
      g.beginPath();
      g.arc(x, y, r + 4 * k, 0, 2 * Math.PI);
      g.stroke();
    }
  }
}
