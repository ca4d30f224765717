"""How long a person waits for the reviewer: in Chromium, on four views of 2048 x 700 px from files.

Run it from the project's root:

    python benchmarks/widget_latency.py                      # JupyterLab, 300 frames, Motion JPEG
    python benchmarks/widget_latency.py --app notebook --codec h264 --json
    python benchmarks/widget_latency.py --codec h264 --frames 100000 --jumps 40
    python benchmarks/widget_latency.py --frames 100000 --jumps 40   # 8 GB on the disk meanwhile

A synthetic mouse of 60 frames is rendered once (``--scene`` keeps it) and its packets follow one
another again and again in the files, as often as frames are asked for; H.264 has a key frame
every 30. Motion JPEG of more than 8 GB is one film, compressed more (quality 70), that all views
show, each from an open file of its own.

*step* is from the key to the painted next frame with nothing fetched beforehand, so reading,
encoding, the way to the browser and painting are all in the time; *key* the same as a person has
it, who presses the arrow ten times a second while the widget fetches what comes next; *jump* is to
a frame at random; *playing* how many frames a second are painted while it plays, nothing being kept
in the browser when it begins; *kernel* what of a step the kernel takes to read and encode; *drag*
whether a dragged point is drawn in the same animation frame as the mouse has moved in; *memory*
what the kernel's process grew by from before the widget was made to after all of it, and *cache*
what of it are decoded frames, kept for stepping back, after the jumps; the aim does not speak of
these.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import time
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np

from pawnb.synthetic import render_mouse_trial
from pawnb.trial import load_trial

TESTS = Path(__file__).parents[1] / "tests"
sys.path[:0] = [str(TESTS / "browser"), str(TESTS / "widgets")]

RENDERED = 60
KEY_EVERY = 30
MOST_BYTES, LONG_QUALITY = 8e9, 70
AIMS = {"step_median_ms": 50, "step_p95_ms": 120, "jump_median_ms": 250, "playing_fps": 20,
        "above_cache_mb": 300}  # fmt: skip

_STEPS = """async ([frames, timeout, ahead, pause]) => {
  const c = document.querySelector('.pawnb-root')._pawnb, times = [];
  if (!ahead) c.frames.prefetch = () => {};
  // a message posted while a frame is drawn is heard once the browser has painted it
  let now = c.painted, heard = () => {};
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => heard();
  Object.defineProperty(c, 'painted', { configurable: true, get: () => now,
    set: (frame) => { now = frame; port2.postMessage(0); } });
  const painted = (frame) => new Promise((done, failed) => {
    const late = setTimeout(() => failed(new Error(`frame ${frame} was not painted`)), timeout);
    heard = () => { if (now === frame) { clearTimeout(late); done(); } };
    port2.postMessage(0); });
  for (const frame of frames) {
    const start = performance.now();
    c.go(frame);
    await painted(frame);
    times.push(performance.now() - start);
    await new Promise((done) => setTimeout(done, pause));
  }
  delete c.painted;
  c.painted = now;
  delete c.frames.prefetch;
  return times; }"""

_PLAY = """async (seconds) => {
  const c = document.querySelector('.pawnb-root')._pawnb;
  let n = 0, last = c.painted;
  for (const frame of [...c.frames.pictures.kept.keys()])
    if (frame !== c.frames.shown) c.frames.pictures.drop(frame);
  c.frames.play(true);
  const start = performance.now();
  await new Promise((done) => {
    const look = () => {
      if (c.painted !== last) { n += 1; last = c.painted; }
      performance.now() - start < seconds * 1000 ? requestAnimationFrame(look) : done(); };
    requestAnimationFrame(look); });
  c.frames.play(false);
  return n / ((performance.now() - start) / 1000); }"""

_DRAG = """async ([view, u, v, moves]) => {
  const c = document.querySelector('.pawnb-root')._pawnb;
  const s = c.stages.find((stage) => stage.name === view);
  const box = s.marks.getBoundingClientRect(), [x, y] = s.toCanvas(u, v);
  const at = (k) => ({ clientX: box.left + x * box.width / s.marks.width + k,
    clientY: box.top + y * box.height / s.marks.height, button: 0, buttons: 1, pointerId: 1,
    isPrimary: true, bubbles: true });
  s.marks.setPointerCapture = () => {};
  s.marks.dispatchEvent(new PointerEvent('pointerdown', at(0)));
  let same = 0;
  for (let k = 1; k <= moves; k++) {
    await new Promise(requestAnimationFrame);
    s.marks.dispatchEvent(new PointerEvent('pointermove', at(k)));
    const asked = c.dirty === true;
    await new Promise(requestAnimationFrame);
    if (asked && !c.dirty) same += 1;
  }
  s.marks.dispatchEvent(new PointerEvent('pointermove', at(0)));
  s.marks.dispatchEvent(new PointerEvent('pointerup', at(0)));
  return same / moves; }"""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--app", choices=["lab", "notebook"], default="lab")
    parser.add_argument("--codec", choices=["mjpeg", "h264"], default="mjpeg")
    parser.add_argument("--frames", type=int, default=300, help="frames of each file")
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--jumps", type=int, default=20)
    parser.add_argument("--scene", type=Path, help="folder in which the rendered mouse is kept")
    parser.add_argument("--scale", type=float, default=1.0, help="1: 2048 x 700 px")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        scene = options.scene or folder / "scene"
        if not (scene / "trial.toml").exists():
            render_mouse_trial(scene, frames=RENDERED, scale=options.scale)
        trial = lengthen(scene, folder / "trial", codec=options.codec, frames=options.frames)
        result = measure(trial, options, folder)
    print(json.dumps(result) if options.json else described(result))


def lengthen(scene: Path, folder: Path, *, codec: str, frames: int) -> Path:
    """Write the scene with its frames again and again; return its ``trial.toml``."""
    trial = load_trial(scene)
    shutil.copytree(scene, folder, ignore=shutil.ignore_patterns("*.avi", "truth", "results"))
    text = (folder / "trial.toml").read_text(encoding="utf-8")
    films = [trial.folder / str(view.video) for view in trial.views]
    size = frames * sum(film.stat().st_size for film in films) / RENDERED
    linked = codec == "mjpeg" and size > MOST_BYTES
    for view, source in zip(trial.views, films, strict=True):
        name = f"{view.name}.{'mp4' if codec == 'h264' else 'avi'}"
        if linked and view is not trial.views[0]:
            (folder / name).hardlink_to(folder / f"{trial.views[0].name}.avi")
        elif codec == "h264" or linked:
            short = folder / f"short-{name}"
            (encode if codec == "h264" else compress)(source, short, trial.fps)
            repeat(short, folder / name, frames)
            short.unlink()
        else:
            repeat(source, folder / name, frames)
        text = text.replace(f'"{view.video}"', f'"{name}"')
    (folder / "trial.toml").write_text(text, encoding="utf-8")
    return folder / "trial.toml"


def encode(source: Path, target: Path, fps: float) -> None:
    """Write a film in H.264 whose packets can follow one another again and again."""
    with av.open(str(source)) as film, av.open(str(target), "w") as out:
        stream = film.streams.video[0]
        # every frame rests on those before it only, back to the last key frame
        options = {"crf": "23", "g": str(KEY_EVERY), "bf": "0", "sc_threshold": "0"}
        coded = out.add_stream("libx264", rate=round(fps), options=options)
        width, height = stream.width // 2 * 2, stream.height // 2 * 2  # H.264 has even sizes only
        coded.width, coded.height, coded.pix_fmt = width, height, "yuv420p"
        for frame in film.decode(stream):
            picture = frame.to_ndarray(format="rgb24")[:height, :width]
            out.mux(coded.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        out.mux(coded.encode())


def compress(source: Path, target: Path, fps: float) -> None:
    """Write a film in Motion JPEG again, smaller."""
    with av.open(str(source)) as film, av.open(str(target), "w") as out:
        stream = film.streams.video[0]
        written = out.add_stream("mjpeg", rate=round(fps))
        written.width, written.height, written.pix_fmt = stream.width, stream.height, "yuvj420p"
        for n, frame in enumerate(film.decode(stream)):
            picture = frame.to_ndarray(format="bgr24")
            _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, LONG_QUALITY])
            packet = av.Packet(data.tobytes())
            packet.pts = packet.dts = n
            packet.is_keyframe, packet.stream = True, written
            packet.time_base = Fraction(1, round(fps))
            out.mux(packet)


def repeat(source: Path, target: Path, frames: int) -> None:
    """Write a film's packets one after the other until it has that many frames."""
    with av.open(str(source)) as film, av.open(str(target), "w") as out:
        stream = film.streams.video[0]
        copied = out.add_stream_from_template(stream)
        packets = [packet for packet in film.demux(stream) if packet.size]
        step = packets[1].pts - packets[0].pts
        kept = [(bytes(p), p.is_keyframe, p.pts, p.dts) for p in packets]
        for n in range(frames):
            data, is_key, pts, dts = kept[n % len(kept)]
            packet = av.Packet(data)
            turn = n // len(kept) * len(kept) * step
            packet.pts, packet.dts, packet.is_keyframe = pts + turn, dts + turn, is_key
            packet.time_base, packet.stream = stream.time_base, copied
            out.mux(packet)


_KERNEL = """
import gc, time, numpy as np, pawnb
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.io.start import read_start
def memory_mb():
    gc.collect()
    text = open('/proc/self/status').read()
    return int(text.split('VmRSS:')[1].split()[0]) / 1024
def cache_mb():
    # of the planes of each picture that is kept
    sources = dict.fromkeys(r.source for r in w._own_views.readers.values())
    planes = (p for s in sources for kept in s._kept.values() for p in vars(kept).values())
    return sum(p.nbytes for p in planes if isinstance(p, np.ndarray)) / 2**20
trial = pawnb.load_trial({trial!r})
clicks = read_start(trial.path(trial.start_file()), trial)
names = [view.name for view in trial.views]
points = sorted(set(clicks['point']))
tracks = make_tracks(range({frames}), points, fps=trial.fps, views=names, unit='mm')
for row in clicks.itertuples():
    at = dict(view=row.view, keypoint=row.point)
    tracks['image_position'].loc[at] = np.array([row.u, row.v])[:, None]
    tracks['image_origin'].loc[at] = ORIGIN_CODE['measured']
    tracks['image_confidence'].loc[at] = 1.0
before = memory_mb()
class Timed(pawnb.widgets.TrackReviewer):
    answers_s = []
    def _answer_want(self, *about):
        began = time.perf_counter()
        super()._answer_want(*about)
        self.answers_s.append(time.perf_counter() - began)
w = Timed(trial, tracks)
w
"""


def measure(trial: Path, options: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """Open the reviewer in the browser, step, jump, play and drag."""
    from jupyter_page import ARGS, NotebookPage, find_browser, jupyter
    from playwright.sync_api import sync_playwright

    root, state = folder / "root", folder / "state"
    root.mkdir()
    state.mkdir()
    rng = np.random.default_rng(0)
    with sync_playwright() as driver, jupyter(root, state, options.app) as url:
        browser = driver.chromium.launch(executable_path=find_browser(), args=ARGS)
        page = browser.new_page(viewport={"width": 1920, "height": 1200})
        notebook = NotebookPage(page, url, options.app, root)
        began = time.perf_counter()
        notebook.show(_KERNEL.format(trial=str(trial), frames=options.frames))
        last = options.frames - 1
        opened = time.perf_counter() - began
        steps = list(range(1, min(last, options.steps) + 1))
        step = page.evaluate(_STEPS, [steps, 10_000, False, 30])
        kernel_ms = 1e3 * float(np.median(notebook.py(f"w.answers_s[-{len(steps)}:]")))
        page.evaluate(_STEPS, [[0], 20_000, False, 300])
        key = page.evaluate(_STEPS, [steps, 10_000, True, 100])
        jumps = [int(frame) for frame in rng.integers(0, last, options.jumps)]
        jump = page.evaluate(_STEPS, [jumps, 20_000, True, 30])
        cache = notebook.py("cache_mb()")  # jumping fills it
        page.evaluate(_STEPS, [[0], 20_000, True, 300])
        playing = page.evaluate(_PLAY, 5)
        notebook.settle()
        view, u, v = notebook.py(
            "next([r.view, r.u, r.v] for r in clicks.itertuples() if r.view == names[0])"
        )
        drag = page.evaluate(_DRAG, [view, u, v, 20])
        grown = notebook.py("memory_mb() - before")
        browser.close()
    return {
        "app": options.app, "codec": options.codec, "frames": options.frames,
        "opened_s": opened,
        "step_median_ms": float(np.median(step)), "step_p95_ms": float(np.percentile(step, 95)),
        "kernel_median_ms": kernel_ms,
        "key_median_ms": float(np.median(key)), "key_p95_ms": float(np.percentile(key, 95)),
        "jump_median_ms": float(np.median(jump)), "jump_p95_ms": float(np.percentile(jump, 95)),
        "playing_fps": playing, "drag_same_frame": drag, "memory_mb": grown, "cache_mb": cache,
        "above_cache_mb": grown - cache,
    }  # fmt: skip


def described(result: dict[str, Any]) -> str:
    """Return the figures as lines, with the aim of each."""
    lines = [f"{result['app']}, {result['codec']}, {result['frames']} frames"]
    for name, value in result.items():
        if isinstance(value, int | float) and name != "frames":
            aim = f"   aim {AIMS[name]}" if name in AIMS else ""
            lines.append(f"{name:18s} {value:8.1f}{aim}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
