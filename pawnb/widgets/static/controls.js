// The buttons, menus, sliders and the help below the pictures.
// Joined with the other files here into one module by frame_canvas.py.

const SPEEDS = [1, 2, 5, 10, 25, 50, 100]; // frames a second

function element(tag, className, properties = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  made.className = className;
  return made;
}

// Change of an element what is different: the browser lays out anew whatever is set, equal or not.
function say(el, properties) {
  for (const [name, value] of Object.entries(properties)) if (el[name] !== value) el[name] = value;
}

// A Canvas (frame_canvas.js) as far as it is operated: it has model, root, bar, actions, sliders,
// frames and connection, and go, edit, focus, fitAll and setRectangle.
class Controls {
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
    this.buildSpeed();
    this.button(this.bar, "+1", "One frame on (Right)", by(1));
    this.button(this.bar, "+10", "Ten frames on (Shift+Right)", by(10));
    if (!this.timeline) this.buildSlider(first, last);
    const ends = { type: "number", min: first, max: last, step: 1, placeholder: "frame" };
    this.number = element("input", "pawnb-number", { ...ends, title: "Go to a frame by its number (G, number, Enter)" });
    this.number.setAttribute("aria-label", "go to frame");
    this.number.onchange = () => {
      if (this.number.value !== "") this.go(Math.round(+this.number.value));
      this.number.value = "";
      this.focus();
    };
    this.caption = element("span", "pawnb-caption");
    // as wide as the longest words: the slider must not move under the mouse that drags it
    const longest = `frame ${last} of ${last}, 0000.000 s (Python is busy)`;
    this.caption.style.width = `${0.9 * longest.length}ch`;
    this.bar.append(...(this.slider ? [this.slider] : []), this.number, this.caption);
    const zoom = "Then drag a rectangle in a view (Z); Shift and drag does it at once";
    const press = () => this.setRectangle(!this.rectangle);
    this.zoomButton = this.button(this.bar, "Zoom rectangle", zoom, press);
    this.zoomButton.setAttribute("aria-pressed", "false");
    const { closer } = this;
    const follows = "Every view shows the part about the chosen point; zooming in one zooms all (V)";
    this.followButton = this.button(this.bar, "Follow", follows, () => closer.follow(!closer.following));
    const enlarges = "A loupe at the mouse (U)";
    this.loupeButton = this.button(this.bar, "Loupe", enlarges, () => closer.magnify(!closer.loupe));
    for (const made of [this.followButton, this.loupeButton]) made.setAttribute("aria-pressed", "false");
    this.button(this.bar, "Whole picture", "Show every view whole again (0)", () => this.fitAll());
  }

  buildSpeed() {
    const title = "Frames a second while playing (+ and -); B plays backwards, Shift+Space in a loop";
    this.speed = element("select", "pawnb-button", { title });
    this.speed.setAttribute("aria-label", "frames a second");
    for (const speed of SPEEDS) this.speed.append(element("option", "", { value: speed, textContent: `${speed} fps` }));
    this.speed.value = this.frames.speed;
    this.speed.onchange = () => { this.frames.speed = +this.speed.value; this.focus(); };
    this.bar.append(this.speed);
  }

  // One speed up or down the list.
  faster(by) {
    const at = Math.max(0, Math.min(SPEEDS.length - 1, SPEEDS.indexOf(this.frames.speed) + by));
    this.speed.value = this.frames.speed = SPEEDS[at];
  }

  // Brightness, contrast and gamma of what is shown; what is tracked and measured stays as it is.
  buildLight() {
    const light = element("details", "pawnb-light");
    light.append(element("summary", "", { textContent: "Brightness, contrast, gamma" }));
    const lines = element("div", "pawnb-sliders");
    const values = { brightness: 0, contrast: 1, gamma: 1 };
    const usual = { ...values };
    const inputs = {};
    const show = () => {
      const changed = Object.keys(values).some((name) => values[name] !== usual[name]);
      const { brightness, contrast, gamma } = values;
      const intercept = 0.5 - 0.5 * contrast + brightness;
      for (const tag of ["R", "G", "B"]) {
        const [power, linear] = this.filter.querySelectorAll(`feFunc${tag}`);
        power.setAttribute("exponent", 1 / gamma);
        linear.setAttribute("slope", contrast);
        linear.setAttribute("intercept", intercept);
      }
      for (const { image } of this.stages) image.style.filter = changed ? `url(#${this.filterId})` : "";
    };
    for (const [name, min, max] of [["brightness", -0.5, 0.5], ["contrast", 0.2, 4], ["gamma", 0.3, 3]]) {
      const line = element("label", "pawnb-line");
      const input = element("input", "", { type: "range", min, max, step: 0.05, value: values[name] });
      inputs[name] = input;
      input.setAttribute("aria-label", name);
      input.oninput = () => { values[name] = +input.value; show(); };
      input.onchange = () => this.focus();
      line.append(element("span", "", { textContent: name }), input);
      lines.append(line);
    }
    light.append(lines);
    this.button(light, "As it is", "The picture as it was filmed", () => {
      Object.assign(values, usual);
      for (const [name, input] of Object.entries(inputs)) input.value = usual[name];
      show();
    });
    this.root.append(light, this.makeFilter());
  }

  makeFilter() {
    this.filterId = `pawnb-light-${this.frames.who}`;
    const holder = element("div", "pawnb-filter");
    const part = (type) => ["R", "G", "B"].map((tag) => `<feFunc${tag} type="${type}"/>`).join("");
    holder.innerHTML = `<svg width="0" height="0" aria-hidden="true"><filter id="${this.filterId}"
      color-interpolation-filters="sRGB"><feComponentTransfer>${part("gamma")}</feComponentTransfer>
      <feComponentTransfer>${part("linear")}</feComponentTransfer></filter></svg>`;
    this.filter = holder;
    return holder;
  }

  // Where there is a timeline, that is the slider.
  buildSlider(first, last) {
    const range = { type: "range", min: first, max: last, value: this.frames.want };
    this.slider = element("input", "pawnb-slider", { ...range, title: "Choose a frame" });
    this.slider.setAttribute("aria-label", "frame");
    this.slider.oninput = () => this.go(+this.slider.value);
    this.slider.onchange = () => this.focus();
  }

  buildHelp() {
    const help = (this.help = element("details", "pawnb-help"));
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

  // Python learns which point is chosen, and may choose one.
  tellSelected() {
    if (this.connection.down) return;
    this.model.set("selected", this.selected || []);
    this.model.save_changes();
  }

  followSelected() {
    const [view, id] = this.model.get("selected") || [];
    this.selected = view === undefined ? null : [view, id];
    this.markSelected();
    this.moved();
    this.redraw();
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
}
