// All views of a trial in one widget: layout, keys, and what a person does.
// Joined with the other files here into one module by frame_canvas.py.
//
// browser -> kernel: {type: "edit", what, who, n, frame, selected, ...}
//                    what: click, moved, hide, select or action
//                    {type: "active"}                                      somebody works here
// kernel -> browser: {type: "done", who, n, version, frame, overlay, go?}   it is on disk
//                    {type: "refresh", version, go?}                       overlays have changed

const GAP = 8; // CSS pixels between views
const HEAD = 32; // height of the line above each view
const TELLING_MS = 5000; // Python is told so often that somebody works here
const WORK = ["keydown", "pointermove", "pointerdown", "wheel"];

class Canvas extends Keys {
  constructor(model, el) {
    super();
    this.model = model;
    this.tall = 0; // CSS px that the words above the pictures have taken so far
    this.waiting = new Map(); // edits that are not yet on disk, and what takes each back here
    this.unanswered = 0; // edits that were on their way when the connection was lost
    this.n = 0;
    this.told = -Infinity; // when Python was told last that somebody works here, ms
    const chosen = model.get("selected") || [];
    this.selected = chosen.length ? chosen : null; // [view, point]
    this.looked = 0; // which look of Python's was shown last
    this.rectangle = false; // whether the next drag zooms
    this.stages = model.get("stages").map((spec) => new Stage(spec, this));
    this.linked = new Linked(model.get("cameras"));
    this.closer = new Closer(this);
    this.frames = new Frames(model, this);
    this.connection = new Connection(model, this.frames.who, () => this.reconnected());
    this.timeline = (model.get("lanes") || []).length ? new Timeline(this) : null;
    this.build(el);
    this.connect();
    if (this.timeline) this.timeline.ask();
    this.frames.step();
  }

  // --- the page --------------------------------------------------------------------

  build(el) {
    const root = (this.root = element("div", "pawnb-root", { tabIndex: 0 }));
    // JupyterLab leaves keys alone inside an element with this attribute
    root.dataset.lmSuppressShortcuts = "true";
    root.setAttribute("role", "group");
    root.setAttribute("aria-label", this.model.get("label"));
    this.status = element("div", "pawnb-status");
    this.status.setAttribute("role", "status");
    this.alarm = element("div", "pawnb-alarm");
    this.alarm.setAttribute("role", "alert");
    this.lost = element("div", "pawnb-lost", { hidden: true });
    this.lost.setAttribute("role", "alert");
    this.grid = element("div", "pawnb-grid");
    this.grid.append(...this.stages.map((stage) => stage.el));
    this.detail = element("div", "pawnb-detail");
    this.bar = element("div", "pawnb-bar");
    this.actions = element("div", "pawnb-bar");
    this.sliders = element("div", "pawnb-sliders");
    this.sheet = new Sheet(this);
    root.append(this.lost, this.status, this.alarm, this.sheet.el, this.grid, this.detail);
    if (this.timeline) root.append(this.timeline.el);
    root.append(this.bar, this.actions, this.sliders);
    this.buildBar();
    this.buildLight();
    this.buildHelp();
    this.showActions();
    this.showSliders();
    this.sheet.show();
    this.showStatus();
    el.append(root);
    root._pawnb = this; // for the tests in a real browser
  }

  // What to do, and below it, smaller, how things stand. The pictures below stand still while
  // something is dragged over them: what would move them waits until it is let go.
  showStatus() {
    if (this.dragging) return;
    const lines = this.model.get("status").split("\n");
    this.status.replaceChildren(...lines.map((text) => element("div", "", { textContent: text })));
    const alarm = this.model.get("alarm"), isNew = alarm && alarm !== this.alarm.textContent;
    this.alarm.textContent = alarm;
    this.alarm.hidden = !alarm;
    // the button that was refused may stand below the pictures, where the words are out of sight
    if (isNew) this.alarm.scrollIntoView({ block: "nearest" });
    // the room that words once took stays theirs: the picture does not jump back up when fewer
    // follow, as the next click may be on its way
    this.tall = Math.max(this.tall, this.status.getBoundingClientRect().height);
    this.status.style.minHeight = `${this.tall}px`;
  }

  // --- the connection to Python (called by Connection and Frames) -------------------------

  // The connection was lost, or is back.
  reconnected() {
    const { down } = this.connection;
    const wasDown = !this.lost.hidden;
    if (down && !wasDown) {
      for (const stage of this.stages) stage.cancel();
      // what got no answer is shown as it was before: it may not have been kept
      this.unanswered = this.waiting.size;
      for (const takeBack of [...this.waiting.values()].reverse()) takeBack();
      this.waiting.clear();
      this.sliding = null;
    }
    this.root.classList.toggle("pawnb-down", down);
    this.showLost();
    this.showActions();
    this.showSliders();
    if (down) this.frames.lost();
    else if (wasDown) {
      this.frames.found();
      if (this.timeline) this.timeline.ask(); // it may have changed meanwhile
    }
    this.moved();
    this.redraw();
  }

  showLost() {
    const { connection, unanswered: n } = this;
    this.lost.hidden = !connection.down;
    const last = n === 1 ? "The last change got no answer" : `The last ${n} changes got no answer`;
    const more = n ? ` ${last} and may not be saved; it is shown as before.` : "";
    this.lost.replaceChildren(connection.words() + more);
    if (!connection.ended) this.button(this.lost, "Ask again", "Is Python there?", () => connection.ask());
  }

  // What was tried is not done, and is said to be so.
  refused() {
    this.lost.classList.remove("pawnb-flash");
    void this.lost.offsetWidth; // so that it flashes every time
    this.lost.classList.add("pawnb-flash");
  }

  // Views stand side by side unless fewer columns make the pictures clearly larger in the
  // height there is.
  layout() {
    const width = this.grid.clientWidth;
    if (!width) return; // in a hidden tab; the observer calls again
    if (width !== this.width) {
      this.width = width;
      this.tall = 0; // words are broken elsewhere now
      this.status.style.minHeight = "";
    }
    let best = { size: 0 };
    for (let columns = this.stages.length; columns >= 1; columns--) {
      const each = (width - GAP * (columns - 1)) / columns;
      let pictures = 0;
      let heads = 0;
      for (let i = 0; i < this.stages.length; i += columns) {
        const row = this.stages.slice(i, i + columns);
        pictures += Math.max(...row.map((stage) => (each * stage.H) / stage.W));
        heads += HEAD + GAP;
      }
      const room = Math.max(100, this.model.get("max_height") - heads);
      const size = Math.floor(each * Math.min(1, room / pictures));
      if (size > 1.25 * best.size) best = { size, columns };
    }
    this.grid.style.gridTemplateColumns = `repeat(${best.columns}, max-content)`;
    for (const stage of this.stages)
      stage.resize(stage.el.classList.contains("pawnb-wide") ? width : best.size);
    if (this.timeline) this.timeline.resize(width);
    this.redraw();
  }

  // --- frames (called by Frames) ---------------------------------------------------------

  // A person chose a frame: playing ends there.
  go(frame) {
    this.frames.play(false);
    this.frames.go(frame);
  }

  // No other frame may show while an edit is being written or a point is in the hand.
  get held() {
    return this.pending > 0 || this.nudged || this.stages.some((s) => s.drag && s.drag.kind === "point");
  }

  get pending() {
    return this.waiting.size;
  }

  get dragging() {
    return this.stages.some((s) => s.drag);
  }

  show(bitmaps, overlay, isNew) {
    if (isNew && overlay.current !== undefined) this.selected = overlay.current;
    if (isNew && overlay.look) this.lookAt(overlay.look);
    this.stages.forEach((stage, k) => {
      stage.bitmap = bitmaps[k];
      if (!isNew) return;
      stage.setOverlay(overlay.views[stage.name] || {});
    });
    if (isNew && !this.dragging) this.showHeads();
    if (isNew) this.closer.apply();
    this.redraw();
  }

  // Python shows a part of each view, once: [u, v, width]; no part at all is the whole.
  lookAt({ id, views }) {
    if (id === this.looked) return;
    this.looked = id;
    for (const stage of this.stages) {
      if (views[stage.name]) stage.lookAt(...views[stage.name]);
      else stage.fit();
    }
  }

  playing(on) {
    this.playButton.textContent = on ? "❚❚ Stop" : "▶ Play";
  }

  // The lines in words: which frame, and the selected point.
  moved() {
    const { shown, want, span, overlay, late: loading } = this.frames;
    if (this.slider) this.slider.value = want;
    if (this.timeline) this.timeline.follow();
    const caption = overlay && overlay.caption ? `, ${overlay.caption}` : "";
    const text = shown === null ? "" : `frame ${shown} of ${span[1]}${caption}`;
    const late = this.connection.busy ? "Python is busy" : `loading ${want}`;
    const said = loading && !this.connection.down ? `${text} (${late})` : text;
    say(this.caption, { textContent: said, title: said });
    const [view, id] = this.selected || [];
    const stage = this.stages.find((s) => s.name === view);
    const chip = stage && (stage.overlay.chips || []).find((c) => c.id === id);
    const waits = this.connection.busy && this.pending;
    const busy = "Python is busy with something else: the last change is not saved yet.";
    const off = this.linking ? this.linked.words(this.stages) : ""; // of a point in the hand
    say(this.detail, { textContent: waits ? busy : off || (chip ? `${view}, ${chip.title}` : "") });
  }

  showHeads() {
    for (const stage of this.stages) this.showHead(stage);
    this.markSelected();
  }

  // Above each view: its name, and every point it tracks as a button; the buttons stay while the
  // points are the same.
  showHead(stage) {
    const { head, el } = stage;
    const chips = stage.overlay.chips || [];
    const wide = el.classList.contains("pawnb-wide");
    const built = JSON.stringify([wide, chips.map(({ id }) => id)]);
    if (stage.built !== built) this.buildHead(stage, chips, wide);
    stage.built = built;
    const made = head.querySelectorAll(".pawnb-chip");
    chips.forEach(({ state, title, colour }, k) => {
      say(made[k], { className: `pawnb-chip pawnb-${state}`, title });
      if (made[k].style.getPropertyValue("--colour") !== colour) made[k].style.setProperty("--colour", colour);
    });
  }

  buildHead(stage, chips, wide) {
    const { head, el } = stage;
    head.replaceChildren(element("span", "pawnb-name", { textContent: stage.name, title: stage.name }));
    for (const { id } of chips) {
      const chip = this.button(head, id, "", () => this.select(stage, id));
      chip.className = "pawnb-chip";
      chip.dataset.point = id;
    }
    if (this.stages.length > 1) {
      const title = wide ? "Show this view smaller again" : "Show this view as wide as it gets";
      const grow = this.button(head, wide ? "Smaller" : "Larger", title, () => {
        el.classList.toggle("pawnb-wide");
        this.showHeads();
        this.layout();
      });
      grow.classList.add("pawnb-grow");
    }
  }

  markSelected() {
    const [view, id] = this.selected || [];
    for (const stage of this.stages) {
      stage.el.classList.toggle("pawnb-here", view === stage.name);
      for (const chip of stage.head.querySelectorAll(".pawnb-chip"))
        say(chip, { ariaPressed: String(view === stage.name && chip.dataset.point === id) });
    }
    if (this.timeline) this.timeline.chosen();
  }

  // Drawn only when something changed, and at most once an animation frame.
  redraw() {
    if (this.dirty || this.closed) return;
    this.dirty = true;
    requestAnimationFrame(() => {
      this.dirty = false;
      if (this.closed) return;
      const [view, id] = this.selected || [];
      this.linkViews();
      for (const stage of this.stages) {
        stage.drawImage();
        stage.drawMarks(view === stage.name ? id : null);
      }
      this.painted = this.frames.shown;
    });
  }

  // What the other views say of the point in the hand, drawn in the same animation frame.
  linkViews() {
    const dragging = this.stages.find(({ drag }) => drag && drag.kind === "point" && drag.moved);
    const held = dragging ? { stage: dragging, point: dragging.drag.point } : this.nudged || null;
    this.linked.follow(this.stages, held);
    if (held) this.detail.textContent = this.linked.words(this.stages) || this.detail.textContent;
    else if (this.linking) this.moved(); // the usual words again
    this.linking = held !== null;
  }

  // Where the points shown in the other views put one that is about to be placed.
  guideOf(stage, id) {
    return this.linked.guide(this.linked.seenBy(this.stages, stage, id), stage);
  }

  // --- what a person does (called by Stage) ----------------------------------------------

  // Whether a turn of the wheel is meant for what is shown here, and not for the page: with Ctrl
  // (Cmd; a pinch on a touchpad comes as that), or once a person has clicked or pressed keys here.
  takesWheel(e) {
    return e.ctrlKey || e.metaKey || this.root.contains(document.activeElement);
  }

  focus() {
    this.root.focus({ preventScroll: true });
  }

  released() {
    this.showStatus();
    this.showHeads();
    this.redraw();
    this.frames.step(); // a frame may have waited for the hand to open
  }

  rezoomed() {
    this.redraw();
    clearTimeout(this.refining); // finer pictures once the wheel stands still
    this.refining = setTimeout(() => this.closed || this.frames.step(), 120);
  }

  select(stage, point) {
    this.frames.play(false);
    this.selected = [stage.name, point];
    this.markSelected();
    this.moved();
    this.closer.apply();
    this.redraw();
    if (this.model.get("tell_selected")) this.edit({ what: "select", view: stage.name, point });
    this.tellSelected();
  }

  // A point was chosen on the timeline: in the view it was chosen in before, or the first that has it.
  choose(point) {
    const has = (stage) => (stage.overlay.chips || []).some((chip) => chip.id === point);
    const own = this.stages.filter(has);
    const stage = own.find((s) => this.selected && s.name === this.selected[0]) || own[0];
    if (stage) this.select(stage, point);
  }

  setRectangle(on) {
    this.rectangle = on;
    this.zoomButton.setAttribute("aria-pressed", on);
  }

  fitAll() {
    this.closer.follow(false);
    for (const stage of this.stages) stage.fit();
  }

  hideSelected() {
    if (!this.selected) return;
    this.edit({ what: "hide", view: this.selected[0], point: this.selected[1] });
  }

  // The point that a click in a view places: what Python asks for, else the chosen point where
  // that has no ring; null where a click places none.
  asked(stage) {
    const { asks, chips = [] } = stage.overlay;
    if (asks !== undefined) return asks;
    const [view, id] = this.selected || [];
    const { state } = chips.find((chip) => chip.id === id) || {};
    const ringless = state === "missing" || state === "reprojected";
    return view === stage.name && ringless ? id : null;
  }

  // Place, without a mouse, the point that a click would place: where the other views put it, else in
  // the middle of what is shown. Alt and an arrow move it then.
  placeAsked() {
    const view = this.selected && this.selected[0];
    const asking = this.stages.filter((stage) => this.asked(stage) !== null);
    const stage = asking.find(({ name }) => name === view) || asking[0];
    if (!stage) return;
    const { scale, tx, ty } = stage.zoom;
    const middle = [
      (stage.image.width / 2 - tx) / scale - 0.5, (stage.image.height / 2 - ty) / scale - 0.5,
    ];
    const [u, v] = this.closer.placeIn(stage, this.asked(stage)) || middle;
    const inside = stage.inside({ u, v }) ? [u, v] : middle;
    this.edit({ what: "click", view: stage.name, u: inside[0], v: inside[1] });
  }

  // Send what a person did; no other frame shows until the kernel says it is on disk. `takeBack`
  // shows things as they were, should no answer come.
  edit(message, takeBack = () => {}) {
    if (this.frames.shown === null) return;
    if (this.connection.down) {
      takeBack();
      this.refused();
      return;
    }
    this.frames.play(false);
    this.unanswered = 0;
    this.waiting.set(++this.n, takeBack);
    const { who, shown } = this.frames;
    const about = { type: "edit", who, n: this.n, frame: shown, selected: this.selected };
    this.connection.send({ ...about, ...message });
  }

  // Somebody works here: the minutes of a review are counted in Python.
  tellActive() {
    const now = performance.now();
    if (this.connection.down || now - this.told < TELLING_MS) return;
    this.told = now;
    try {
      this.model.send({ type: "active" });
    } catch {
      // a closed line, which the next edit notices
    }
  }

  done({ who, n, version, frame, overlay, go }) {
    const mine = who === this.frames.who;
    if (mine) this.waiting.delete(n);
    if (this.pending) this.connection.asked();
    this.slide();
    this.frames.renew(version);
    this.frames.overlays.set(frame, overlay);
    this.frames.go(mine && go != null ? go : this.frames.want);
  }

  // --- messages ---------------------------------------------------------------------------

  connect() {
    const { model, frames } = this;
    this.handlers = {
      "change:frame": () => frames.follow(),
      "change:actions": () => { this.showActions(); if (this.timeline) this.timeline.bar.show(); },
      "change:stretch": () => this.timeline && this.timeline.chosen(),
      "change:selected": () => this.followSelected(),
      "change:cameras": () => { this.linked = new Linked(model.get("cameras")); },
      "change:sheet": () => this.sheet.show(),
      "change:sliders": () => this.showSliders(),
      "change:status": () => this.showStatus(),
      "change:alarm": () => this.showStatus(),
      "msg:custom": (message, buffers) => {
        if (message.type === "frame" && message.who === frames.who)
          frames.received(message, buffers || []);
        else if (message.type === "done") this.done(message);
        else if (message.type === "lanes" && this.timeline) this.timeline.received(message);
        else if (message.type === "refresh") {
          frames.renew(message.version);
          frames.go(message.go ?? frames.want);
        }
      },
    };
    for (const [event, handler] of Object.entries(this.handlers)) model.on(event, handler);
    this.root.addEventListener("keydown", (e) => this.key(e));
    if (model.get("counts_minutes")) {
      const told = { capture: true, passive: true };
      for (const event of WORK) this.root.addEventListener(event, () => this.tellActive(), told);
    }
    this.observer = new ResizeObserver(() => this.layout());
    this.observer.observe(this.grid);
    this.themes = new MutationObserver(() => this.timeline && this.timeline.redraw());
    this.themes.observe(document.body, { attributes: true });
  }

  close() {
    this.closed = true;
    this.observer.disconnect();
    this.themes.disconnect();
    clearTimeout(this.refining);
    this.connection.close();
    for (const [event, handler] of Object.entries(this.handlers)) this.model.off(event, handler);
    this.frames.close();
  }
}

export default {
  render({ model, el }) {
    const canvas = new Canvas(model, el);
    return () => canvas.close();
  },
};
