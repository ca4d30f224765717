"""What the canvas sends, without a browser: messages in, messages out."""

import base64
import threading
import time
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import small_trial as scene

from pawnb.core.pixels.colour import GreyPicture
from pawnb.core.pixels.yuv import YuvPicture
from pawnb.core.video.views import Frame
from pawnb.errors import InputError, VideoError
from pawnb.figures.style import colour_legs, style
from pawnb.widgets.frame_canvas import FrameCanvas, encode_jpeg
from pawnb.workflow.export.colours import point_colours


class FakeViews:
    """Views that draw their pictures; the first frame is 2, and frame 9 is damaged.

    Like a decoder they have a place in the file: two callers at once would mix it up.
    """

    names = tuple(scene.POINTS)
    first_frame, n_frames = 2, 20
    readers = dict.fromkeys(names, SimpleNamespace(width=scene.WIDTH, height=scene.HEIGHT))

    def frame(self, index):
        if index == 9:
            raise VideoError("frame 9 cannot be decoded; the file is damaged there.")
        self.at = index
        time.sleep(0.005)
        return {
            name: SimpleNamespace(image=lambda k=k, at=self.at: scene.picture(at, k))
            for k, name in enumerate(self.names)
        }


class Recorded(FrameCanvas):
    """A canvas whose messages are kept, and whose edits fail when asked to."""

    def __init__(self, **options):
        self.sent, self.edits = [], []
        super().__init__(FakeViews(), **options)

    def send(self, content, buffers=None):
        self.sent.append((content, buffers or []))

    def edit(self, what, message):
        self.edits.append((what, message["frame"]))
        if what == "hide":
            raise InputError("not that one.")
        if what == "moved":
            raise ZeroDivisionError
        return 7

    def overlay(self, frame):
        return {"views": {}, "caption": f"version {self._version}"}


@pytest.fixture
def canvas():
    made = Recorded()
    yield made
    made.close()


def want(canvas, frame, **more):
    return want_several(canvas, [frame], **more)[0]


def want_several(canvas, frames, **more):
    """Ask for frames in one message; the answers come from another thread."""
    message = {"type": "want", "who": "me", "frames": frames, "shrink": [1, 2, 4], "pixels": True}
    n = len(canvas.sent)
    canvas._receive(canvas, message | {"plain": False} | more, [])
    end = time.monotonic() + 30
    while True:
        answers = [sent for sent in canvas.sent[n:] if sent[0].get("frame") in frames]
        answers = [sent for sent in answers if sent[0]["type"] == "frame"]
        if len(answers) >= len(frames):
            return answers
        assert time.monotonic() < end
        time.sleep(0.001)


def edit(canvas, what, frame=5):
    canvas._receive(canvas, {"type": "edit", "what": what, "who": "me", "n": 1, "frame": frame}, [])


def decoded(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR_RGB)


def test_a_frame_comes_as_one_jpeg_a_view_as_small_as_asked(canvas):
    answer, pictures = want(canvas, 5)
    assert (answer["type"], answer["who"], answer["frame"], answer["sent"]) == (
        "frame", "me", 5, True,
    )  # fmt: skip
    assert answer["shrink"] == [1, 2, 4]
    assert [decoded(p).shape for p in pictures] == [(360, 640, 3), (180, 320, 3), (90, 160, 3)]
    # red disc of FR in cam1, in RGB order, and the bar code of frame 5
    image = decoded(pictures[0]).astype(int)
    u, v = scene.seen(5)[0, 0].astype(int)
    np.testing.assert_allclose(image[v, u], [230, 60, 60], atol=12)
    assert [image[10, 10 + 20 * bit, 0] > 128 for bit in range(3)] == [True, False, True]


def test_frames_asked_for_together_come_one_after_the_other(canvas):
    answers = want_several(canvas, [5, 9, 6])
    assert [answer["frame"] for answer, _ in answers] == [5, 9, 6]
    assert [len(pictures) for _, pictures in answers] == [3, 0, 3]


def test_a_frame_that_fails_in_some_other_way_is_answered_and_said_too(canvas, monkeypatch):
    monkeypatch.setattr(canvas, "overlay", lambda _frame: 1 / 0)
    answer, pictures = want(canvas, 5)
    said = "frame 5 cannot be shown: ZeroDivisionError: division by zero"
    assert (answer["error"], canvas.alarm, pictures) == (said, said, [])


def test_edits_do_not_wait_for_a_frame_that_is_read(canvas, monkeypatch):
    reading, may_end = threading.Event(), threading.Event()
    frame = canvas._views.frame

    def slow(index):
        reading.set()
        assert may_end.wait(30)
        return frame(index)

    monkeypatch.setattr(canvas._views, "frame", slow)
    asking = threading.Thread(target=want, args=(canvas, 5))
    asking.start()
    assert reading.wait(30)
    edit(canvas, "click")
    may_end.set()
    asking.join(30)
    assert [answer["type"] for answer, _ in canvas.sent] == ["done", "frame"]


@pytest.mark.parametrize("shrink", [1.25, 2.75, 3.5, 4])
def test_a_picture_is_made_as_small_as_asked_in_quarters_too(shrink):
    """A slanted ramp has, wherever it is read, the value of that place."""
    v, u = np.mgrid[:96, :128]
    ramp = np.round((u + 0.5) + (v + 0.5) / 2).astype(np.uint8)
    frame = Frame(0, GreyPicture(ramp), (0, 0, 128, 96))
    data = np.frombuffer(encode_jpeg(frame, shrink=shrink, quality=100), np.uint8)
    small = cv2.imdecode(data, cv2.IMREAD_UNCHANGED).astype(float)
    assert small.shape == (round(96 / shrink), round(128 / shrink))
    rows, columns = (np.arange(n) + 0.5 for n in small.shape)
    expected = columns * 128 / small.shape[1] + (rows[:, None] * 96 / small.shape[0]) / 2
    np.testing.assert_allclose(small[1:-1, 1:-1], expected[1:-1, 1:-1], atol=2.5)


def test_pixels_that_the_browser_has_are_not_sent_again(canvas):
    answer, pictures = want(canvas, 5, pixels=False)
    assert (answer["sent"], pictures) == (False, [])
    assert answer["overlay"]["caption"] == "version 0"


def test_text_instead_of_binary_messages_on_request(canvas):
    answer, pictures = want(canvas, 5, plain=True)
    assert pictures == []
    assert decoded(base64.b64decode(answer["pictures"][1])).shape == (180, 320, 3)


def test_a_damaged_frame_is_answered_in_words(canvas):
    answer, pictures = want(canvas, 9)
    assert pictures == []
    assert answer["error"] == "frame 9 cannot be decoded; the file is damaged there."
    assert canvas.alarm == answer["error"]
    assert not answer["sent"]


def test_every_edit_is_answered_when_it_is_done_and_makes_a_new_version(canvas):
    edit(canvas, "click")
    answer, _ = canvas.sent[-1]
    assert canvas.edits == [("click", 5)]
    assert answer == {
        "type": "done", "who": "me", "n": 1, "go": 7, "version": 1, "frame": 5,
        "overlay": {"views": {}, "caption": "version 1"},
    }  # fmt: skip
    assert want(canvas, 5)[0]["version"] == 1


def test_an_edit_that_is_refused_is_answered_too_and_said(canvas):
    edit(canvas, "hide")
    assert canvas.sent[-1][0]["type"] == "done"
    assert canvas.alarm == "not that one."
    edit(canvas, "click")
    assert canvas.alarm == ""


def test_the_browser_is_not_left_waiting_by_a_fault(canvas):
    with pytest.raises(ZeroDivisionError):
        edit(canvas, "moved")
    assert canvas.sent[-1][0]["type"] == "done"


def test_refresh_tells_every_view_that_overlays_changed(canvas):
    canvas.refresh(go=6)
    assert canvas.sent[-1][0] == {"type": "refresh", "version": 1, "go": 6}


def test_stages_and_span_follow_the_views(canvas):
    assert canvas.stages[1] == {"name": "cam2", "width": 640, "height": 360}
    assert (canvas.span, canvas.frame) == ([2, 19], 2)
    with pytest.raises(InputError, match=r"^frame 1 is not in the recording \(2 to 19\)\.$"):
        FrameCanvas(FakeViews(), frame=1)


def test_frames_asked_for_from_several_threads_are_not_mixed(canvas):
    def many(start):
        for frame in range(start, start + 4):
            want(canvas, frame)

    threads = [threading.Thread(target=many, args=(start,)) for start in (2, 12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert len(canvas.sent) == 8
    for answer, pictures in canvas.sent:
        image = decoded(pictures[0])
        bits = [image[10, 10 + 20 * bit, 0] > 128 for bit in range(scene.BITS)]
        assert sum(1 << place for place, on in enumerate(bits) if on) == answer["frame"]


def test_grey_pictures_stay_grey():
    grey = np.tile(np.arange(0, 240, 4, np.uint8), (40, 1))
    data = encode_jpeg(SimpleNamespace(image=lambda: grey))
    back = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert back.shape == (40, 60)
    np.testing.assert_allclose(back.astype(int), grey.astype(int), atol=6)


@pytest.mark.parametrize("size", [(64, 48), (63, 47)])
def test_a_frame_is_made_smaller_before_it_is_made_rgb_with_the_same_result(size):
    """Expected is the mean of squares of the whole picture."""
    width, height = size
    v, u = np.mgrid[:height, :width]
    luma = (60 + 2 * u + v).astype(np.uint8)
    chroma = [np.full((-(-height // 2), -(-width // 2)), value, np.uint8) for value in (100, 150)]
    picture = YuvPicture(luma, *chroma, steps=(2, 2), full_range=True)
    frame = Frame(0, picture, (0, 0, width, height))
    small = decoded(encode_jpeg(frame, shrink=2, quality=100))
    assert small.shape == (round(height / 2), round(width / 2), 3)
    expected = cv2.resize(frame.image(), small.shape[1::-1], interpolation=cv2.INTER_AREA)
    np.testing.assert_allclose(small.astype(int), expected.astype(int), atol=3)


def test_a_frame_outside_the_recording_is_refused_whenever_it_is_set(canvas):
    for frame in (999, 1, -1):
        with pytest.raises(InputError, match=rf"^frame {frame} is not in the recording"):
            canvas.frame = frame
    assert canvas.frame == 2
    canvas.frame = 5
    assert canvas.frame == 5
    for span in ((2, 999), (0, 5), (7, 3)):
        with pytest.raises(InputError, match=rf"^span is {span[0]} to {span[1]}; expected"):
            FrameCanvas(FakeViews(), span=span)


def test_points_have_the_colours_that_their_legs_have_in_the_figures():
    paws = ["FR", "HR", "FL", "HL"]
    figures = colour_legs(paws)
    assert point_colours(paws) == figures
    # nose and ears leave the paws as they were, and look like none of them
    named = point_colours(["FR", "nose", "HR", "ear_L", "FL", "HL"])
    assert list(named) == ["FR", "nose", "HR", "ear_L", "FL", "HL"]
    assert {paw: named[paw] for paw in paws} == figures
    assert len(set(named.values())) == 6
    # names that another program's user gave
    foreign = point_colours(["hindpaw_left", "snout", "front_paw_R"])
    assert (foreign["hindpaw_left"], foreign["front_paw_R"]) == (figures["HL"], figures["FR"])
    spider = [f"{side}{rank}" for side in "LR" for rank in range(1, 5)]
    assert point_colours(spider) == colour_legs(spider)
    assert len(set(point_colours([f"p{i}" for i in range(8)]).values())) == 8


def test_what_a_person_chose_for_a_leg_holds_over_the_video_as_well():
    with style(leg_colours={"HR": "black"}):
        assert point_colours(["FR", "HR"])["HR"] == "#000000"


def test_what_is_chosen_is_a_view_and_a_point():
    canvas = Recorded()
    heard = []
    canvas.observe(lambda change: heard.append(change["new"]), "selected")
    canvas.selected = ["cam1", "FR"]
    for wrong in (["nowhere", "FR"], ["cam1"]):
        with pytest.raises(
            InputError, match=r"selected is .*; expected a view of cam1, cam2, cam3"
        ):
            canvas.selected = wrong
    canvas.selected = []
    assert heard == [["cam1", "FR"], []]
    canvas.close()
