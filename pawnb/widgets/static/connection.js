// Whether Python hears what is done here.
//
// What Jupyter knows of the kernel tells it at once. Where Jupyter cannot be asked, and where a
// kernel is there that knows nothing of this widget, a question without an answer does.
// browser -> kernel: {type: "hello", who}    kernel -> browser: {type: "hello", who}
// Joined with the other files here by frame_canvas.py and by surroundings.py.

const PATIENCE_MS = 6000; // so long an answer may take of a kernel that has nothing else to do
const PAUSE_MS = 1000; // between two questions, so that no question follows on the last one's stir
const ENDED = ["restarting", "autorestarting", "terminating", "dead"];

class Connection {
  // `changed` is called whenever `down`, `busy` or `ended` have changed.
  constructor(model, who, changed) {
    Object.assign(this, { model, who, changed });
    this.down = false; // nothing that is done here would be kept
    this.busy = false; // Python does something else first
    this.ended = false; // and it will never hear again
    this.timer = null;
    this.askedAt = -PAUSE_MS;
    this.sure = false; // whether it was asked if anybody is there, and got no answer yet
    this.kernel = (model.widget_manager && model.widget_manager.kernel) || null;
    this.look = () => this.lookAtKernel();
    this.hear = () => this.heard();
    model.on("msg:custom", this.hear);
    for (const signal of this.signals()) signal.connect(this.look);
  }

  signals() {
    const { kernel } = this;
    if (!kernel) return [];
    return [kernel.statusChanged, kernel.connectionStatusChanged, kernel.disposed].filter(Boolean);
  }

  // Send something that Python answers.
  send(message) {
    try {
      this.model.send(message);
    } catch {
      this.set({ down: true, busy: false }); // a closed line
      return;
    }
    this.asked();
  }

  asked() {
    if (this.timer === null) this.timer = setTimeout(() => this.doubt(), PATIENCE_MS);
  }

  heard() {
    clearTimeout(this.timer);
    Object.assign(this, { timer: null, sure: false });
    this.set({ down: false, busy: false });
  }

  // Ask whether anybody is there.
  ask() {
    if (this.ended) return;
    this.askedAt = performance.now();
    this.send({ type: "hello", who: this.who });
  }

  doubt() {
    this.timer = null;
    const { kernel } = this;
    const there = kernel && kernel.connectionStatus === "connected";
    const busy = there && kernel.status === "busy";
    if (there && !busy && !this.sure) {
      // a picture may take long while Python is free to answer something else
      this.sure = true;
      this.ask();
      return;
    }
    this.set({ down: !busy, busy: !!busy });
    if (busy) this.asked();
    else if (there || !kernel) this.ask(); // the last question may have been lost with a line
  }

  lookAtKernel() {
    const { kernel } = this;
    if (kernel.isDisposed || ENDED.includes(kernel.status))
      this.set({ down: true, busy: false, ended: true });
    else if (kernel.connectionStatus !== "connected") this.set({ down: true, busy: false });
    else if (this.down && performance.now() - this.askedAt > PAUSE_MS) this.ask(); // it may be back
  }

  set(state) {
    if (this.ended || Object.keys(state).every((name) => this[name] === state[name])) return;
    Object.assign(this, state);
    this.changed();
  }

  // What a person should know, in sentences; nothing while all is well.
  words() {
    if (!this.down) return "";
    const why = this.ended
      ? "The kernel of this widget has ended or was restarted: run its cell again."
      : "Python does not answer: its connection is lost, or it is busy with something else.";
    return `Not connected: nothing is saved. ${why} What was saved before is in its file.`;
  }

  close() {
    clearTimeout(this.timer);
    this.model.off("msg:custom", this.hear);
    for (const signal of this.signals()) signal.disconnect(this.look);
  }
}
