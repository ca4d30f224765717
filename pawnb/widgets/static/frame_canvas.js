// All views of a trial in one widget: layout, buttons, keys, and what a person does.
// connection.js, stick.js, stage.js (class Stage), frames.js (class Frames) and this file are joined
// into one module.
//
// browser -> kernel: {type: "edit", what, who, n, frame, selected, ...}
//                    what: click, moved, hide, select or action
// kernel -> browser: {type: "done", who, n, version, frame, overlay, go?}   it is on disk
//                    {type: "refresh", version, go?}                       overlays have changed

const GAP = 8; // CSS pixels between views
const HEAD = 32; // height of the line above each view

function element(tag, className, properties = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  made.className = className;
  return made;
}

class Canvas {
  constructor(model, el) {
    this.model = model;
    this.tall = 0; // CSS px that the words above the pictures have taken so far
    this.waiting = new Map(); // edits that are not yet on disk, and what takes each back here
    this.unanswered = 0; // edits that were on their way when the connection was lost
    this.n = 0;
    this.selected = null; // [view, point]
    this.rectangle = false; // whether the next drag zooms
    this.stages = model.get("stages").map((spec) => new Stage(spec, this));
    this.frames = new Frames(model, this);
    this.connection = new Connection(model, this.frames.who, () => this.reconnected());
    this.build(el);
    this.connect();
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
    root.append(this.lost, this.status, this.alarm, this.grid, this.detail, this.bar, this.actions, this.sliders);
    this.buildBar();
    this.buildHelp();
    this.showActions();
    this.showSliders();
    this.showStatus();
    el.append(root);
    root._pawnb = this; // for the tests in a real browser
  }

  button(parent, text, title, onclick) {
    const made = element("button", "pawnb-button", { type: "button", textContent: text, title });
    made.onclick = () => { onclick(); this.focus(); };
    parent.append(made);
    return made;
  }

  buildBar() {
    const [first, last] = this.frames.span;
    const by = (n) => () => this.go(this.frames.want + n);
    this.button(this.bar, "−10", "Ten frames back (Shift+Left)", by(-10));
    this.button(this.bar, "−1", "One frame back (Left)", by(-1));
    const toggle = () => this.frames.play(!this.frames.playing);
    this.playButton = this.button(this.bar, "", "Play or stop (Space)", toggle);
    this.playButton.classList.add("pawnb-play");
    this.playing(false);
    this.button(this.bar, "+1", "One frame on (Right)", by(1));
    this.button(this.bar, "+10", "Ten frames on (Shift+Right)", by(10));
    const range = { type: "range", min: first, max: last, value: this.frames.want };
    this.slider = element("input", "pawnb-slider", { ...range, title: "Choose a frame" });
    this.slider.setAttribute("aria-label", "frame");
    this.slider.oninput = () => this.go(+this.slider.value);
    this.slider.onchange = () => this.focus();
    this.caption = element("span", "pawnb-caption");
    // as wide as the longest words: the slider must not move under the mouse that drags it
    const longest = `frame ${last} of ${last}, 0000.000 s (Python is busy)`;
    this.caption.style.width = `${0.9 * longest.length}ch`;
    this.bar.append(this.slider, this.caption);
    const zoom = "Then drag a rectangle in a view (Z); Shift and drag does it at once";
    const press = () => this.setRectangle(!this.rectangle);
    this.zoomButton = this.button(this.bar, "Zoom rectangle", zoom, press);
    this.zoomButton.setAttribute("aria-pressed", "false");
    this.button(this.bar, "Whole picture", "Show every view whole again (0)", () => this.fitAll());
  }

  buildHelp() {
    const help = element("details", "pawnb-help");
    help.append(element("summary", "", { textContent: "Mouse and keys" }));
    for (const [key, text] of this.model.get("keys_help")) {
      const line = element("div", "");
      line.append(element("span", "pawnb-key", { textContent: key }), text);
      help.append(line);
    }
    this.root.append(help);
  }

  // The buttons and menus that Python asks for.
  showActions() {
    this.actions.replaceChildren();
    for (const { id, text, title, enabled = true, options } of this.model.get("actions")) {
      const send = (value) => this.edit({ what: "action", action: id, value });
      let made;
      if (options) {
        made = element("select", "pawnb-button", { title });
        made.setAttribute("aria-label", title);
        for (const [value, words] of [["", text], ...options])
          made.append(element("option", "", { value, textContent: words }));
        made.onchange = () => { send(made.value); made.value = ""; this.focus(); };
        this.actions.append(made);
      } else made = this.button(this.actions, text, title, () => send(null));
      made.disabled = !enabled || this.connection.down;
      made.dataset.action = id;
    }
  }

  // The sliders that Python asks for; one in the hand is left alone.
  showSliders() {
    const specs = this.model.get("sliders");
    const known = [...this.sliders.children].map((line) => line.dataset.slider);
    if (specs.map(({ id }) => id).join() !== known.join())
      this.sliders.replaceChildren(...specs.map((spec) => this.makeSlider(spec)));
    specs.forEach(({ text, title, min, max, step, value }, i) => {
      const line = this.sliders.children[i];
      const [name, input, shown] = line.children;
      line.title = title;
      name.textContent = text;
      input.setAttribute("aria-label", text);
      input.disabled = this.connection.down;
      const typing = input.type === "number" || this.sliding;
      if (input === document.activeElement && typing) return;
      Object.assign(input, { min, max: max ?? "", step, value });
      shown.textContent = input.type === "number" ? "" : value;
    });
  }

  makeSlider({ id, number }) {
    const line = element("label", "pawnb-line");
    line.dataset.slider = id;
    const input = element("input", "", { type: number ? "number" : "range" });
    const shown = element("span", "pawnb-value");
    line.append(element("span", ""), input, shown);
    const take = () => {
      this.sliding = { id, value: +input.value };
      this.slide();
    };
    input.oninput = number ? null : () => { shown.textContent = input.value; take(); };
    // a number is sent once it is typed: Enter, or a click elsewhere
    input.onchange = () => { number ? take() : this.slide(); this.focus(); };
    return line;
  }

  // One value of a slider is on its way at a time, and the newest wins.
  slide() {
    if (!this.sliding || this.pending > 0) return;
    const { id, value } = this.sliding;
    this.sliding = null;
    this.edit({ what: "action", action: id, value });
  }

  // What to do, and below it, smaller, how things stand. The pictures below stand still while
  // something is dragged over them: what would move them waits until it is let go.
  showStatus() {
    if (this.dragging) return;
    const lines = this.model.get("status").split("\n");
    this.status.replaceChildren(...lines.map((text) => element("div", "", { textContent: text })));
    this.alarm.textContent = this.model.get("alarm");
    this.alarm.hidden = !this.model.get("alarm");
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
    else if (wasDown) this.frames.found();
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
    return this.pending > 0 || this.stages.some((s) => s.drag && s.drag.kind === "point");
  }

  get pending() {
    return this.waiting.size;
  }

  get dragging() {
    return this.stages.some((s) => s.drag);
  }

  show(bitmaps, overlay, isNew) {
    if (isNew && overlay.current !== undefined) this.selected = overlay.current;
    this.stages.forEach((stage, k) => {
      stage.bitmap = bitmaps[k];
      if (!isNew) return;
      stage.setOverlay(overlay.views[stage.name] || {});
      if (!this.dragging) this.showHead(stage);
    });
    this.redraw();
  }

  playing(on) {
    this.playButton.textContent = on ? "❚❚ Stop" : "▶ Play";
  }

  // The lines in words: which frame, and the selected point.
  moved() {
    const { shown, want, span, overlay, loading } = this.frames;
    this.slider.value = want;
    const caption = overlay && overlay.caption ? `, ${overlay.caption}` : "";
    const text = shown === null ? "" : `frame ${shown} of ${span[1]}${caption}`;
    const late = this.connection.busy ? "Python is busy" : `loading ${want}`;
    this.caption.textContent = loading && !this.connection.down ? `${text} (${late})` : text;
    this.caption.title = this.caption.textContent;
    const [view, id] = this.selected || [];
    const stage = this.stages.find((s) => s.name === view);
    const chip = stage && (stage.overlay.chips || []).find((c) => c.id === id);
    this.detail.textContent = chip ? `${view}, ${chip.title}` : "";
    if (this.connection.busy && this.pending)
      this.detail.textContent = "Python is busy with something else: the last change is not saved yet.";
  }

  // Above each view: its name, and every point it tracks as a button.
  showHead(stage) {
    const { head, el } = stage;
    head.replaceChildren(element("span", "pawnb-name", { textContent: stage.name }));
    for (const { id, state, title, colour } of stage.overlay.chips || []) {
      const chip = this.button(head, id, title, () => this.select(stage, id));
      chip.className = `pawnb-chip pawnb-${state}`;
      chip.dataset.point = id;
      chip.style.setProperty("--colour", colour);
    }
    if (this.stages.length > 1) {
      const wide = el.classList.contains("pawnb-wide");
      const title = wide ? "Show this view smaller again" : "Show this view as wide as it gets";
      const grow = this.button(head, wide ? "Smaller" : "Larger", title, () => {
        el.classList.toggle("pawnb-wide");
        this.showHead(stage);
        this.layout();
      });
      grow.classList.add("pawnb-grow");
    }
    this.markSelected();
  }

  markSelected() {
    const [view, id] = this.selected || [];
    for (const stage of this.stages) {
      stage.el.classList.toggle("pawnb-here", view === stage.name);
      for (const chip of stage.head.querySelectorAll(".pawnb-chip"))
        chip.setAttribute("aria-pressed", view === stage.name && chip.dataset.point === id);
    }
  }

  // Drawn only when something changed, and at most once an animation frame.
  redraw() {
    if (this.dirty || this.closed) return;
    this.dirty = true;
    requestAnimationFrame(() => {
      this.dirty = false;
      if (this.closed) return;
      const [view, id] = this.selected || [];
      for (const stage of this.stages) {
        stage.drawImage();
        stage.drawMarks(view === stage.name ? id : null);
      }
      this.painted = this.frames.shown;
    });
  }

  // --- what a person does (called by Stage) ----------------------------------------------

  focus() {
    this.root.focus({ preventScroll: true });
  }

  released() {
    this.showStatus();
    for (const stage of this.stages) this.showHead(stage);
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
    this.redraw();
    if (this.model.get("tell_selected")) this.edit({ what: "select", view: stage.name, point });
  }

  setRectangle(on) {
    this.rectangle = on;
    this.zoomButton.setAttribute("aria-pressed", on);
  }

  fitAll() {
    for (const stage of this.stages) stage.fit();
  }

  hideSelected() {
    if (!this.selected) return;
    this.edit({ what: "hide", view: this.selected[0], point: this.selected[1] });
  }

  // The point that a click in a view places: what Python asks for, else the chosen point where
  // that is missing; null where a click places none.
  asked(stage) {
    const { asks, chips = [] } = stage.overlay;
    if (asks !== undefined) return asks;
    const [view, id] = this.selected || [];
    const missing = chips.some((chip) => chip.id === id && chip.state === "missing");
    return view === stage.name && missing ? id : null;
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

  done({ who, n, version, frame, overlay, go }) {
    const mine = who === this.frames.who;
    if (mine) this.waiting.delete(n);
    if (this.pending) this.connection.asked();
    this.slide();
    this.frames.renew(version);
    this.frames.overlays.set(frame, overlay);
    this.frames.go(mine && go != null ? go : this.frames.want);
  }

  // --- keys and messages -----------------------------------------------------------------

  key(e) {
    e.stopPropagation(); // nothing typed here is meant for the notebook
    const control = { SELECT: /./, INPUT: /Arrow|Home|End|Page/, BUTTON: /^( |Enter)$/, SUMMARY: /^( |Enter)$/ };
    const used = e.target.type === "number" ? /./ : control[e.target.tagName];
    if (used && used.test(e.key)) return; // the control that has the focus needs it
    const command = e.ctrlKey || e.metaKey ? "Ctrl+" : "";
    const typed = command + (e.shiftKey ? "Shift+" : "") + e.key;
    const { frames } = this;
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
      Escape: () => this.stages.some((s) => s.cancel()) || this.setRectangle(false),
      Delete: () => this.hideSelected(),
      Backspace: () => this.hideSelected(),
    };
    const asked = this.model.get("actions").find((a) => (a.keys || []).includes(typed));
    if (!asked && !own[typed]) return;
    e.preventDefault();
    if (!asked) own[typed]();
    else if (asked.enabled !== false) this.edit({ what: "action", action: asked.id, value: null });
  }

  connect() {
    const { model, frames } = this;
    this.handlers = {
      "change:frame": () => frames.follow(),
      "change:actions": () => this.showActions(),
      "change:sliders": () => this.showSliders(),
      "change:status": () => this.showStatus(),
      "change:alarm": () => this.showStatus(),
      "msg:custom": (message, buffers) => {
        if (message.type === "frame" && message.who === frames.who)
          frames.received(message, buffers || []);
        else if (message.type === "done") this.done(message);
        else if (message.type === "refresh") {
          frames.renew(message.version);
          frames.go(message.go ?? frames.want);
        }
      },
    };
    for (const [event, handler] of Object.entries(this.handlers)) model.on(event, handler);
    this.root.addEventListener("keydown", (e) => this.key(e));
    this.observer = new ResizeObserver(() => this.layout());
    this.observer.observe(this.grid);
  }

  close() {
    this.closed = true;
    this.observer.disconnect();
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
