// The line above the timeline: which stretch is chosen, and what can be done to it.
// Joined with the other files here into one module by frame_canvas.py.

const WIDE = 1100; // CSS px from which two of the points to swap with are buttons; else one

class StretchBar {
  constructor(timeline) {
    this.timeline = timeline;
    this.el = element("div", "pawnb-bar pawnb-stretch");
    this.inView = ""; // the one view that is meant; empty: every view
  }

  get can() {
    return this.timeline.model.get("lanes_do");
  }

  show() {
    const { timeline, el } = this;
    const { stretch } = timeline;
    const point = timeline.point();
    const text = (words) => el.append(element("span", "pawnb-said", { textContent: words, title: words }));
    el.replaceChildren();
    if (!stretch && (point === null || !this.can.includes("swap"))) {
      text("Drag along a lane to choose a stretch; drag the frame numbers to go through the recording.");
      return;
    }
    const name = element("bdi", "pawnb-point", { textContent: point || "(no name)", title: point });
    el.append(name);
    if (stretch) {
      const { first, last } = stretch;
      text(`frames ${first} to ${last} (${last - first + 1})`);
    } else text("from here to where they meet next:");
    if (this.can.includes("swap")) this.offerSwaps(point);
    if (stretch) this.offerRest();
  }

  press(text, title, action, more) {
    const { host } = this.timeline;
    const made = host.button(this.el, text, title, () => this.act(action, more));
    made.disabled = host.connection.down || !this.free;
    made.dataset.stretch = action;
    return made;
  }

  // Whether Python takes corrections now: its own buttons say so.
  get free() {
    const undo = this.timeline.model.get("actions").find(({ id }) => id === "retrack");
    return !undo || undo.enabled !== false;
  }

  partners(point) {
    const lane = this.timeline.lanes.find(({ id }) => id === point);
    return lane ? lane.partners : [];
  }

  offerSwaps(point) {
    const others = this.partners(point);
    const shown = this.timeline.width < WIDE ? 1 : 2; // the rest is a menu
    others.slice(0, shown).forEach((other, i) => {
      const key = i ? "" : " (X)";
      this.press(`Swap with ${other || "(no name)"}`, `${point} and ${other} are exchanged${key}`, "swap", { other });
    });
    if (others.length <= shown) return;
    const menu = element("select", "pawnb-button", { title: "Exchange it with another point" });
    menu.setAttribute("aria-label", menu.title);
    menu.append(element("option", "", { value: "", textContent: "with …" }));
    others.slice(shown).forEach((other, i) =>
      menu.append(element("option", "", { value: String(i + shown), textContent: other || "(no name)" })));
    menu.onchange = () => { this.act("swap", { other: others[+menu.value] }); this.timeline.host.focus(); };
    menu.disabled = this.timeline.host.connection.down || !this.free;
    this.el.append(menu);
  }

  offerRest() {
    const { timeline } = this;
    const rest = [
      ["interpolate", "Interpolate", "Lead it smoothly over the stretch, through what was placed by hand (N)"],
      ["hide", "Hide", "It cannot be seen over the stretch; stays so when tracked again (H)"],
      ["delete", "Delete", "What was tracked over the stretch is wrong; tracking again may find it (Delete)"],
      ["retrack", "Track again", "Track the stretch again from what was placed by hand in it"],
    ];
    for (const [action, words, title] of rest)
      if (this.can.includes(action)) this.press(words, title, action, {});
    const views = timeline.host.stages.map((stage) => stage.name);
    if (views.length > 1 && this.can.includes("hide")) this.offerViews(views);
    timeline.host.button(this.el, "✕", "No stretch (Esc)", () => timeline.clear());
  }

  offerViews(views) {
    const menu = element("select", "pawnb-button", { title: "Where that is done" });
    menu.setAttribute("aria-label", menu.title);
    for (const view of ["", ...views])
      menu.append(element("option", "", { value: view, textContent: view ? `in ${view}` : "in all views" }));
    menu.value = views.includes(this.inView) ? this.inView : "";
    menu.onchange = () => { this.inView = menu.value; this.timeline.host.focus(); };
    this.el.append(menu);
  }

  // Do it to the stretch; without one, a swap goes to where the points meet next.
  act(action, more = {}) {
    const { stretch, host } = this.timeline;
    const point = this.timeline.point();
    if (point === null || !this.can.includes(action) || !this.free) return;
    if (!stretch && action !== "swap") return;
    const chosen = stretch ? [stretch.first, stretch.last] : null;
    const other = action === "swap" ? more.other ?? this.partners(point)[0] : undefined;
    if (action === "swap" && other === undefined) return;
    const view = stretch ? this.inView || null : null;
    host.edit({ what: "stretch", action, point, other, view, stretch: chosen });
  }
}
