// What keys do. Joined with the other files here into one module by frame_canvas.py.

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
      0: () => this.fitAll(),
      z: () => this.setRectangle(!this.rectangle),
      g: () => this.number.select(),
      Escape: () =>
        this.stages.some((s) => s.cancel()) || (timeline && timeline.clear()) || this.setRectangle(false),
      Delete: () => this.hideSelected(),
      Backspace: () => this.hideSelected(),
    };
    return timeline ? { ...own, ...this.timelineKeys(own) } : own;
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
    const command = e.ctrlKey || e.metaKey ? "Ctrl+" : "";
    const typed = command + (e.shiftKey ? "Shift+" : "") + e.key;
    const own = this.ownKeys();
    const asked = this.model.get("actions").find((a) => (a.keys || []).includes(typed));
    if (!asked && !own[typed]) return;
    e.preventDefault();
    if (!asked) own[typed]();
    else if (asked.enabled !== false) this.edit({ what: "action", action: asked.id, value: null });
  }
}
