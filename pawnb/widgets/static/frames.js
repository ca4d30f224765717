// Which frame is wanted, which is shown, and how frames come from the kernel.
//
// kernel -> browser: {type: "frame", who, frame, sent, shrink, overlay, version, error?} + a JPEG a view
// browser -> kernel: {type: "want", who, frames, shrink, pixels, plain}
// One request of a frame that is wanted is in flight at a time and the newest wins, so no queue
// builds up while somebody holds a key down. Frames are fetched beforehand, one at a time, when
// nothing else is asked, and while playing: Python then reads a frame while the one before is drawn.
// Then several are asked for in one message, as Jupyter shows for each that the kernel is busy.

const BITMAP_BYTES = 256e6; // decoded pictures kept in the browser
const LATE_MS = 150; // a frame that is not there by then is said to be waited for
const TOGETHER = 4; // frames asked for in one message while playing
const AHEAD = 6; // frames fetched beforehand, in the direction of travel

// The pictures of recent frames, oldest out first.
class Pictures {
  constructor() {
    this.kept = new Map();
    this.bytes = 0;
  }
  get(frame) {
    return this.kept.get(frame);
  }
  put(frame, entry, spare) {
    this.drop(frame);
    entry.bytes = entry.bitmaps.reduce((sum, b) => sum + b.width * b.height * 4, 0);
    this.kept.set(frame, entry);
    this.bytes += entry.bytes;
    for (const old of [...this.kept.keys()]) {
      if (this.bytes <= BITMAP_BYTES) break;
      if (old !== frame && !spare.includes(old)) this.drop(old);
    }
  }
  use(frame) {
    const entry = this.kept.get(frame);
    this.kept.delete(frame);
    this.kept.set(frame, entry);
  }
  drop(frame) {
    const entry = this.kept.get(frame);
    if (!entry) return;
    this.kept.delete(frame);
    this.bytes -= entry.bytes;
    for (const bitmap of entry.bitmaps) bitmap.close();
  }
  clear() {
    for (const frame of [...this.kept.keys()]) this.drop(frame);
  }
}

class Frames {
  // `host` has stages, connection and held, and is told: show(bitmaps, overlay, isNew), moved(),
  // playing(on), refused().
  constructor(model, host) {
    this.model = model;
    this.host = host;
    this.who = Math.random().toString(36).slice(2); // the same widget may be shown twice
    this.pictures = new Pictures();
    this.overlays = new Map(); // what is drawn over each frame, of the present version only
    this.version = -1;
    this.want = model.get("frame");
    this.shown = null;
    this.overlay = null;
    this.bitmaps = null;
    this.direction = 1;
    this.asked = null; // the wanted frame that is on its way
    this.ahead = null; // the last frame on its way that is fetched beforehand
    this.coming = new Set(); // all frames on their way
    this.decoding = new Set();
    this.failed = new Set(); // frames that cannot be read are not asked for again and again
    this.late = false; // whether the frame that is wanted lets a person wait
    this.waiting = null;
    this.playing = false;
    this.speed = 25; // frames a second; no frame is skipped, so what is too fast is as fast as it goes
    this.by = 1; // -1: backwards
    this.loop = false;
    this.plain = model.get("transport") === "base64";
  }

  get span() {
    return this.model.get("span");
  }

  get loading() {
    return this.want !== this.shown && !this.failed.has(this.want);
  }

  go(frame) {
    const [first, last] = this.span;
    frame = Math.max(first, Math.min(last, frame));
    if (this.host.connection.down && !this.there(frame)) {
      this.host.refused();
      frame = this.shown ?? frame;
    }
    if (frame !== this.want) this.direction = frame > this.want ? 1 : -1;
    this.want = frame;
    this.failed.delete(frame);
    this.step();
  }

  there(frame) {
    return this.pictures.get(frame) && this.overlays.has(frame);
  }

  // Python hears nothing any more: what was asked for will not come.
  lost() {
    this.play(false);
    this.asked = this.ahead = null;
    this.coming.clear();
    if (this.shown !== null) this.want = this.shown;
  }

  // Python is back: what is drawn may have changed meanwhile.
  found() {
    this.version = -1;
    this.overlays.clear();
    this.failed.clear();
    this.step();
  }

  // Pictures are fine enough when no view asks for smaller pixels than they have.
  fine(frame) {
    const entry = this.pictures.get(frame);
    return entry && this.host.stages.every((stage, k) => entry.shrink[k] <= stage.shrink);
  }

  // Do the next thing there is to do: show the frame, ask for it, or fetch one beforehand.
  step() {
    const frame = this.want;
    // while an edit is being written or a point is in the hand, this frame stays
    if (!this.host.held || frame === this.shown) {
      const there = this.there(frame);
      if (there) this.display(frame);
      if ((there && this.fine(frame)) || this.decoding.has(frame)) this.prefetch();
      else if (!this.failed.has(frame)) {
        this.request(frame);
        if (this.playing) this.prefetch();
      }
    }
    this.watch();
    this.host.moved();
  }

  // Words about a frame that comes at once would only have the browser draw the page once more.
  watch() {
    if (!this.loading) {
      clearTimeout(this.waiting);
      Object.assign(this, { waiting: null, late: false });
    } else if (this.waiting === null)
      this.waiting = setTimeout(() => {
        this.late = true;
        this.host.moved();
      }, LATE_MS);
  }

  // step() runs again when the answer comes, or Python is back. What is fetched beforehand does not
  // keep a frame that is wanted waiting, but for what Python has begun.
  request(frame, kind = "asked", more = []) {
    if (this[kind] !== null || this.host.connection.down || this.coming.has(frame)) return;
    const frames = [frame, ...more];
    this[kind] = frames.at(-1);
    for (const one of frames) this.coming.add(one);
    const shrink = this.host.stages.map((stage) => stage.shrink);
    const { who, plain } = this;
    const pixels = !this.fine(frame);
    this.host.connection.send({ type: "want", who, frames, shrink, pixels, plain });
  }

  prefetch() {
    const [first, last] = this.span;
    const entry = this.pictures.get(this.shown);
    const room = entry ? Math.floor(BITMAP_BYTES / entry.bytes) - 3 : 1;
    const frames = [];
    for (let i = 1; i <= Math.min(AHEAD, room) && frames.length < (this.playing ? TOGETHER : 1); i++) {
      const frame = this.want + i * this.direction;
      if (frame < first || frame > last || this.failed.has(frame)) break;
      const there = this.fine(frame) && this.overlays.has(frame);
      if (!there && !this.decoding.has(frame) && !this.coming.has(frame)) frames.push(frame);
      else if (frames.length) break;
    }
    if (frames.length) this.request(frames[0], "ahead", frames.slice(1));
  }

  async received(message, buffers) {
    const { frame, error, sent, shrink, overlay, version } = message;
    if (frame === this.asked) this.asked = null;
    if (frame === this.ahead) this.ahead = null;
    this.coming.delete(frame);
    if (error) {
      this.failed.add(frame);
      if (frame === this.want) this.play(false);
    } else {
      if (this.version < 0) this.version = version;
      // an answer from before the last edit brings its pictures, but not its overlay
      if (version === this.version) this.overlays.set(frame, overlay);
      const data = message.pictures ? message.pictures.map(fromBase64) : [...buffers];
      if (sent && data.length) {
        await this.decode(frame, shrink, data);
        if (this.closed) return;
      } else if (sent) this.plain = true; // binary buffers get lost on the way: ask for text
    }
    this.step();
  }

  async decode(frame, shrink, data) {
    this.decoding.add(frame);
    this.step(); // the next request goes out meanwhile
    const jpeg = (bytes) => createImageBitmap(new Blob([bytes], { type: "image/jpeg" }));
    const bitmaps = await Promise.all(data.map(jpeg));
    this.decoding.delete(frame);
    if (this.closed) {
      for (const bitmap of bitmaps) bitmap.close();
      return;
    }
    if (frame === this.shown) this.host.show((this.bitmaps = bitmaps), this.overlay, false);
    this.pictures.put(frame, { bitmaps, shrink }, [this.shown, this.want]);
  }

  display(frame) {
    const { bitmaps } = this.pictures.get(frame);
    const overlay = this.overlays.get(frame);
    this.pictures.use(frame);
    if (frame === this.shown && overlay === this.overlay && bitmaps === this.bitmaps) return;
    const isNew = overlay !== this.overlay;
    Object.assign(this, { shown: frame, overlay, bitmaps });
    this.host.show(bitmaps, overlay, isNew);
    clearTimeout(this.telling);
    this.telling = setTimeout(() => this.tell(), 150);
  }

  // Python learns which frame is looked at once the person stays there.
  tell() {
    if (this.closed || this.host.connection.down || this.model.get("frame") === this.shown) return;
    this.told = this.shown;
    this.model.set("frame", this.shown);
    this.model.save_changes();
  }

  // Python chose another frame (and not only heard of this one).
  follow() {
    const frame = this.model.get("frame");
    if (frame !== this.told) this.go(frame);
  }

  // What is drawn over the frames has changed: it is asked for again when they are shown.
  renew(version) {
    if (version === this.version) return;
    this.version = version;
    this.overlays.clear();
  }

  // What is played: the stretch that is chosen on the timeline while that is looped, else all.
  get range() {
    const stretch = this.loop && this.host.timeline ? this.host.timeline.stretch : null;
    return stretch ? [stretch.first, stretch.last] : this.span;
  }

  play(on, { backwards = false, loop = false } = {}) {
    if (on === this.playing) return;
    this.playing = on;
    this.host.playing(on);
    if (!on) return;
    Object.assign(this, { by: backwards ? -1 : 1, loop });
    const [first, last] = this.range;
    if (loop && (this.want < first || this.want > last)) this.go(first);
    let due = -Infinity; // when the next frame should come, ms
    const tick = (now) => {
      if (!this.playing || this.closed) return;
      // playing waits for each frame to be painted; one that came late is not made up for
      if (this.shown === this.want && this.host.painted === this.shown && now >= due - 4) {
        const each = 1000 / this.speed;
        due = Math.max(due + each, now); // not from now on: screens are drawn at times of their own
        if (!this.next()) return this.play(false);
      }
      requestAnimationFrame(tick); // not called in a hidden tab, so playing waits there
    };
    requestAnimationFrame(tick);
  }

  // Go on by one frame; false where there is none.
  next() {
    const [first, last] = this.range;
    let to = this.want + this.by;
    if (this.loop && (to > last || to < first)) to = this.by > 0 ? first : last;
    if (to > last || to < first) return false;
    this.go(to);
    return true;
  }

  close() {
    this.closed = true;
    clearTimeout(this.telling);
    clearTimeout(this.waiting);
    this.pictures.clear();
  }
}

function fromBase64(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}
