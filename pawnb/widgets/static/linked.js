// A point in the hand, as the other views see it: computed here, so that it follows the mouse.
//
// `cameras` of the model: DLT coefficients L1..L11 of each calibrated view, for the pictures as they
// are shown (without the distortion of the lens), so that lines are straight.
// Joined with the other files here into one module by frame_canvas.py.

const CROSS = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const DOT = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

class Linked {
  // `cameras`: of each view's name the eleven coefficients.
  constructor(cameras) {
    this.cameras = new Map();
    for (const [name, L] of Object.entries(cameras || {}))
      this.cameras.set(name, [L.slice(0, 4), L.slice(4, 8), [...L.slice(8, 11), 1]]);
  }

  knows(name) {
    return this.cameras.size > 1 && this.cameras.has(name);
  }

  // The two planes, through the camera, that give u and that give v.
  planes(name, u, v) {
    const [first, second, third] = this.cameras.get(name);
    return [first.map((x, i) => x - u * third[i]), second.map((x, i) => x - v * third[i])];
  }

  // The two ends, within a picture of W x H px, of the line on which what is at (u, v) of one view
  // lies in another; null where it misses the picture. As find_epipolar_line of sightlines.py.
  line(from, u, v, { name, W, H }) {
    const [p, q] = this.planes(from, u, v);
    const along = CROSS(p, q);
    const size = DOT(along, along);
    if (!(size > 0)) return null;
    const [toP, toQ] = [CROSS(along, p), CROSS(q, along)];
    const near = [0, 1, 2].map((i) => (-p[3] * toQ[i] - q[3] * toP[i]) / size);
    const to = this.cameras.get(name);
    const ends = [[...near, 1], [...along, 0]].map((x) => {
      const seen = to.map((row) => DOT(row, x));
      const length = Math.hypot(...seen);
      return seen.map((s) => s / length);
    });
    return clip(CROSS(...ends), W, H);
  }

  // Where in space two or more views put a point: least squares on the DLT equations, as
  // triangulate of dlt/projection.py. `seen`: [view, u, v] of each.
  place(seen) {
    const rows = seen.flatMap(([name, u, v]) => this.planes(name, u, v));
    const N = [0, 1, 2].map((i) => [0, 1, 2].map((j) => rows.reduce((s, r) => s + r[i] * r[j], 0)));
    const b = [0, 1, 2].map((i) => -rows.reduce((s, r) => s + r[i] * r[3], 0));
    const minors = [CROSS(N[1], N[2]), CROSS(N[2], N[0]), CROSS(N[0], N[1])];
    const determinant = DOT(N[0], minors[0]);
    const trace = N[0][0] + N[1][1] + N[2][2];
    if (!(determinant > 1e-15 * trace ** 3)) return null; // lines of sight side by side
    return [0, 1, 2].map((i) => DOT(minors.map((m) => m[i]), b) / determinant);
  }

  project(name, xyz) {
    const [u, v, w] = this.cameras.get(name).map((row) => DOT(row, [...xyz, 1]));
    return [u / w, v / w];
  }

  // Where views other than `own` see a point, [view, u, v]: what was placed by hand, and only
  // without any of that what was tracked.
  seenBy(stages, own, id) {
    const marks = stages
      .filter((stage) => stage !== own && this.knows(stage.name))
      .map(({ name, overlay }) => ({ name, mark: (overlay.points || []).find((mark) => mark.id === id) }))
      .filter(({ mark }) => mark && !["predicted", "reprojected"].includes(mark.origin));
    const byHand = marks.filter(({ mark }) => mark.origin === undefined || mark.origin === "edited");
    return (byHand.length ? byHand : marks).map(({ name, mark }) => [name, mark.u, mark.v]);
  }

  // What every stage draws of the point in the hand of one of them (`held`: {stage, point}, or null):
  // `live` is {id, colour, line, at, off}, and for the view of the hand {id, guide}.
  follow(stages, held) {
    for (const stage of stages) stage.live = null;
    if (!held || held.point.kind || !this.knows(held.stage.name)) return;
    const { stage: own, point: { id, u, v, colour } } = held;
    const seen = this.seenBy(stages, own, id);
    const xyz = seen.length ? this.place([[own.name, u, v], ...seen]) : null;
    for (const stage of stages) {
      if (stage === own || !this.knows(stage.name)) continue;
      const at = xyz && this.project(stage.name, xyz);
      const mark = at && (stage.overlay.points || []).find((one) => one.id === id);
      const off = mark ? Math.hypot(mark.u - at[0], mark.v - at[1]) : null;
      stage.live = { id, colour, line: this.line(own.name, u, v, stage), at, off };
    }
    own.live = { id, guide: this.guide(seen, own) };
  }

  // Where those who see a point put it in a view: one place, the two ends of a line, or null.
  guide(seen, stage) {
    if (!seen.length || !this.knows(stage.name)) return null;
    if (seen.length === 1) {
      const [[name, u, v]] = seen;
      return this.line(name, u, v, stage);
    }
    const xyz = this.place(seen);
    return xyz && [this.project(stage.name, xyz)];
  }

  // How far the point in the hand is from what each other view says, in words; "" where none does.
  words(stages) {
    const told = stages.filter(({ live }) => live && live.off != null);
    const parts = told.map(({ name, live }) => `${pixels(live.off)} in ${name}`);
    return parts.length ? `${told[0].live.id} is off by ${parts.join(", ")}` : "";
  }
}

function pixels(off) {
  return `${off < 10 ? off.toFixed(1) : off.toFixed(0)} px`;
}

// The ends within a picture of the line a u + b v + c = 0; null where it misses the picture.
function clip([a, b, c], W, H) {
  const scale = Math.hypot(a, b);
  if (!(scale > 1e-12 * Math.abs(c))) return null;
  const foot = [(-c * a) / scale ** 2, (-c * b) / scale ** 2];
  const along = [-b / scale, a / scale];
  let [start, end] = [-Infinity, Infinity];
  for (const [i, high] of [[0, W - 0.5], [1, H - 0.5]]) {
    if (along[i] === 0) {
      if (foot[i] < -0.5 || foot[i] > high) return null;
      continue;
    }
    const ends = [(-0.5 - foot[i]) / along[i], (high - foot[i]) / along[i]].sort((x, y) => x - y);
    [start, end] = [Math.max(start, ends[0]), Math.min(end, ends[1])];
  }
  if (!(start < end)) return null;
  return [start, end].map((t) => [foot[0] + t * along[0], foot[1] + t * along[1]]);
}
