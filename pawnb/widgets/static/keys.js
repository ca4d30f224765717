// What keys do. Joined with the other files here into one module by frame_canvas.py.

const STILL_MS = 300; // so long after the last key a point that is moved by keys is kept
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

// A Canvas (frame_canvas.js) as far as keys are concerned.
class Keys extends Controls {
  // Keys of every canvas; those that Python asks for come first.
  ownKeys() {
    const { frames, timeline } = this;
    const own = {
      ArrowRight: () => this.go(frames.want + 1),
      ArrowLeft: () => this.go(frames.want - 1),
      "Shift+ArrowRight": () => this.go(frames.want + 10),
      "Shift+ArrowLeft": () => this.go(frames.want - 10),
      Home: () => this.go(frames.span[0]),
      End: () => this.go(frames.span[1]),
      " ": () => frames.play(!frames.playing),
      b: () => this.playOtherwise({ backwards: true }),
      "Shift+ ": () => this.playOtherwise({ loop: true }),
      "+": () => this.faster(1),
      "Shift++": () => this.faster(1),
      "-": () => this.faster(-1),
      "?": () => this.showHelp(),
      "Shift+?": () => this.showHelp(),
      0: () => this.fitAll(),
      z: () => this.setRectangle(!this.rectangle),
      v: () => this.closer.follow(!this.closer.following),
      u: () => this.closer.magnify(!this.closer.loupe),
      e: () => this.placeAsked(),
      g: () => this.number.select(),
      Escape: () =>
        this.stages.some((s) => s.cancel()) || (timeline && timeline.clear()) || this.setRectangle(false),
      Delete: () => this.hideSelected(),
      Backspace: () => this.hideSelected(),
    };
    return timeline ? { ...own, ...this.timelineKeys(own) } : own;
  }

  playOtherwise(how) {
    const was = this.frames.playing;
    this.frames.play(false);
    if (!was) this.frames.play(true, how);
  }

  showHelp() {
    this.help.open = !this.help.open;
    if (this.help.open) this.help.scrollIntoView({ block: "nearest" });
  }

  // Alt and an arrow: the chosen point by 1 px, with Shift by 0.1 px; kept once the keys rest.
  nudge(e) {
    const way = WAYS[e.key];
    if (!e.altKey || !way || this.connection.down || this.pending) return false;
    const [view, id] = this.selected || [];
    const stage = this.stages.find((one) => one.name === view);
    const point = this.nudged ? this.nudged.point : stage && this.nudgeable(stage, id);
    if (!point || stage.drag) return false;
    this.frames.play(false);
    const by = e.shiftKey ? 0.1 : 1;
    if (!this.nudged && stage.stick) stage.stick.grab();
    this.nudged ||= { stage, point, was: [point.u, point.v] };
    point.u = Math.min(Math.max(point.u + by * way[0], -0.49), stage.W - 0.51);
    point.v = Math.min(Math.max(point.v + by * way[1], -0.49), stage.H - 0.51);
    if (stage.stick) stage.stick.drag(point.id, point.u, point.v, true);
    clearTimeout(this.nudging);
    this.nudging = setTimeout(() => this.keepNudge(), STILL_MS);
    this.redraw();
    return true;
  }

  // The point that keys move: of a stick animal the tip of the chosen leg.
  nudgeable(stage, id) {
    const moved = stage.stick ? stage.stick.handles() : stage.overlay.points || [];
    return moved.find((one) => one.id === id);
  }

  keepNudge() {
    clearTimeout(this.nudging);
    const { nudged } = this;
    this.nudged = null;
    if (!nudged || this.closed) return;
    const { stage, point, was } = nudged;
    const { stick } = stage;
    if (stick) {
      const before = stick.start;
      stick.release();
      const told = { what: "moved", view: stage.name, point: point.id, u: point.u, v: point.v, whole: true };
      this.edit(told, () => { stick.spec = before; });
      return;
    }
    const moved = { what: "moved", view: stage.name, point: point.id, u: point.u, v: point.v, whole: true };
    this.edit(moved, () => { [point.u, point.v] = was; });
  }

  timelineKeys(own) {
    const { timeline } = this;
    const act = (action) => () => timeline.bar.act(action);
    const erase = (key) => () => (timeline.stretch ? timeline.bar.act("delete") : own[key]());
    return {
      i: () => timeline.mark(false),
      o: () => timeline.mark(true),
      x: act("swap"),
      n: act("interpolate"),
      h: act("hide"),
      Delete: erase("Delete"),
      Backspace: erase("Backspace"),
    };
  }

  key(e) {
    e.stopPropagation(); // nothing typed here is meant for the notebook
    const control = { SELECT: /./, INPUT: /Arrow|Home|End|Page/, BUTTON: /^( |Enter)$/, SUMMARY: /^( |Enter)$/ };
    const used = e.target.type === "number" ? /./ : control[e.target.tagName];
    if (used && used.test(e.key)) return; // the control that has the focus needs it
    if (this.nudge(e)) {
      e.preventDefault(); // no going back in the browser
      return;
    }
    if (e.altKey && WAYS[e.key]) {
      // where nothing can be moved now, another frame would show, and be corrected by the next key
      e.preventDefault();
      return;
    }
    if (e.key !== "Alt" && e.key !== "Shift") this.keepNudge();
    const command = e.ctrlKey || e.metaKey ? "Ctrl+" : "";
    // a letter is what is on its key, whether Caps Lock is on or not
    const letter = /^\p{L}$/u.test(e.key);
    const key = letter ? (e.shiftKey ? e.key.toUpperCase() : e.key.toLowerCase()) : e.key;
    const typed = command + (e.shiftKey ? "Shift+" : "") + key;
    const own = this.ownKeys();
    const asked = this.model.get("actions").find((a) => (a.keys || []).includes(typed));
    if (!asked && !own[typed]) return;
    e.preventDefault();
    if (!asked) own[typed]();
    else if (asked.enabled !== false) this.edit({ what: "action", action: asked.id, value: null });
  }
}
