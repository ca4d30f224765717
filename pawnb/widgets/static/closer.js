// A closer look: zoom that follows the chosen point in every view at once, and a loupe at the mouse.
// Joined with the other files here into one module by frame_canvas.py.

const FOLLOWED_TIMES = 4; // how far the views are zoomed when following begins with whole pictures
const LOUPE_PX = 70; // its radius, CSS px
const LOUPE_TIMES = 4; // how much it enlarges what is shown

class Closer {
  // `host` is the canvas: it has stages, selected, dragging, guideOf, redraw and rezoomed.
  constructor(host) {
    this.host = host;
    this.following = false;
    this.loupe = false;
    this.times = FOLLOWED_TIMES;
  }

  follow(on) {
    this.following = on;
    const most = Math.max(...this.host.stages.map((stage) => stage.zoom.scale / stage.fitScale));
    if (on) this.times = most > 1.01 ? most : FOLLOWED_TIMES;
    this.host.followButton.setAttribute("aria-pressed", on);
    this.apply();
  }

  // Every view shows the part about the chosen point, each as far enlarged as the others.
  apply() {
    if (!this.following || !this.host.selected || this.host.dragging) return;
    for (const stage of this.host.stages) {
      const place = this.placeIn(stage, this.host.selected[1]);
      if (place) stage.lookAt(...place, stage.W / this.times);
    }
  }

  // A person zoomed in one view: the others follow.
  zoomed(stage) {
    if (!this.following) return;
    this.times = Math.max(1, stage.zoom.scale / stage.fitScale);
    this.apply();
  }

  // Where a view has a point, or else where the others put it.
  placeIn(stage, id) {
    const { points = [], hollow = [] } = stage.overlay;
    const handles = stage.stick ? stage.stick.handles() : [];
    const found = [...points, ...handles, ...hollow].find((point) => point.id === id);
    if (found) return [found.u, found.v];
    const guide = stage.guides[id] || this.host.guideOf(stage, id);
    return guide && guide.length === 1 ? guide[0] : null;
  }

  magnify(on) {
    this.loupe = on;
    this.host.loupeButton.setAttribute("aria-pressed", on);
    this.host.rezoomed(); // finer pictures are fetched
  }

  draw(stage, g, k) {
    const at = stage.mouse;
    if (!this.loupe || !at || !stage.bitmap) return;
    const r = LOUPE_PX * k;
    const scale = stage.zoom.scale * LOUPE_TIMES;
    const x = Math.min(Math.max(at.x, r), stage.marks.width - r);
    // above the mouse, or below it where there is no room
    const y = at.y > 2.2 * r ? at.y - 1.2 * r : Math.min(at.y + 1.2 * r, stage.marks.height - r);
    g.save();
    g.beginPath();
    g.arc(x, y, r, 0, 2 * Math.PI);
    g.clip();
    g.fillStyle = "#222";
    g.fillRect(x - r, y - r, 2 * r, 2 * r);
    g.imageSmoothingEnabled = false;
    const [left, top] = [x - (at.u + 0.5) * scale, y - (at.v + 0.5) * scale];
    g.filter = stage.image.style.filter || "none"; // as bright as the picture
    g.drawImage(stage.bitmap, left, top, stage.W * scale, stage.H * scale);
    g.filter = "none";
    g.restore();
    const cross = () => {
      g.beginPath();
      g.arc(x, y, r, 0, 2 * Math.PI);
      g.moveTo(x - 8 * k, y);
      g.lineTo(x + 8 * k, y);
      g.moveTo(x, y - 8 * k);
      g.lineTo(x, y + 8 * k);
      g.stroke();
    };
    stage.outlined(g, k, 1.2, "#fff", cross);
  }
}
