"""Films that were exchanged, or put for another, after a start was made in them."""

from __future__ import annotations

import shutil

import av
import cv2
import numpy as np
import pytest

from pawnb.core.video import open_views
from pawnb.core.video.doubts.exchanged_films import film_codes, tell_other_films
from pawnb.trial import Animal, Trial, View


def codes_of(folder, **films):
    """The codes of films, by view."""
    views = tuple(View(name=name, video=str(film)) for name, film in films.items())
    trial = Trial(
        kind="paws", name="t", fps=50.0, animal=Animal(id="m"), folder=folder, views=views
    )
    with open_views(trial) as opened:
        return film_codes(opened.readers)


def pictures(folder, image, *, count=2):
    """A folder of pictures as a film."""
    folder.mkdir()
    for k in range(count):
        cv2.imwrite(str(folder / f"{k}.png"), image.astype(np.uint8))
    return folder


@pytest.fixture
def films(tmp_path):
    """Films of two cameras, one that is flat, and one of the second as a small darker JPEG."""
    rng = np.random.default_rng(5)
    one, two = (cv2.GaussianBlur(rng.uniform(0, 255, (64, 160)), (0, 0), 9) for _ in "ab")
    one, two = (cv2.normalize(a, None, 20, 200, cv2.NORM_MINMAX) for a in (one, two))
    small = tmp_path / "small"
    small.mkdir()
    for k in range(2):
        half = cv2.resize(two, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(small / f"{k}.jpg"), (half * 0.7).astype(np.uint8))
    return {
        "one": pictures(tmp_path / "one", one),
        "two": pictures(tmp_path / "two", two),
        "flat": pictures(tmp_path / "flat", np.full((64, 160), 9.0)),
        "small": small,
    }


def test_exchanged_films_are_said(tmp_path, films):
    clicked = {n: {c} for n, c in codes_of(tmp_path, a=films["one"], b=films["two"]).items()}
    now = codes_of(tmp_path, a=films["two"], b=films["one"])
    first, second = tell_other_films(now, clicked)
    assert first.startswith("the clicks of view a were made in another film than it shows now: ")
    assert "it shows the film of b;" in first
    assert second.startswith("the clicks of view b were")
    assert not tell_other_films(now, {})
    # some of them were clicked anew since
    clicked["a"].add(now["a"])
    assert len(tell_other_films(now, clicked)) == 2


def test_a_film_that_was_put_for_another_is_said(tmp_path, films):
    posed = {"top": {codes_of(tmp_path, a=films["one"])["a"]}}
    (said,) = tell_other_films(codes_of(tmp_path, top=films["two"]), posed, start="poses")
    assert said.startswith("the poses of view top were made in another film than it shows now, and")
    assert said.endswith("make the poses anew")
    # of a flat picture nothing is known
    assert not tell_other_films(codes_of(tmp_path, top=films["flat"]), posed)


def test_films_compressed_again_renamed_or_flat_are_not_said_to_be_exchanged(tmp_path, films):
    clicked = {n: {c} for n, c in codes_of(tmp_path, a=films["one"], b=films["two"]).items()}
    again = codes_of(tmp_path, a=films["one"], b=films["small"])
    assert not tell_other_films(again, clicked)
    assert codes_of(tmp_path, a=films["flat"]) == {"a": ""}
    assert not tell_other_films({"a": "", "b": ""}, clicked)
    # a spreadsheet that changed the cells, and views of one film
    assert not tell_other_films(again, {"a": {"1.2E+16"}, "b": {"x"}})
    both = codes_of(tmp_path, a=films["one"], b=films["one"])
    assert not tell_other_films(both, {name: {code} for name, code in both.items()})


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["mouse-4cam-cage", "real-clips/fly_ball_left"])
def test_real_cameras_are_told_apart_though_compressed_again(real_data, tmp_path, folder):
    """Cameras side by side about one cage or one fly; H.264, crf 30."""
    films = sorted(real_data(folder).glob("cam*.mp4"))
    clicked = codes_of(tmp_path, **{film.stem: film for film in films})
    assert len(set(clicked.values())) == len(films) >= 3
    known = {name: {code} for name, code in clicked.items()}
    again = {}
    for film in films:
        with av.open(str(film)) as container:
            first = next(container.decode(video=0)).reformat(format="yuv420p")
        again[film.stem] = tmp_path / f"again-{film.stem}.mp4"
        with av.open(str(again[film.stem]), "w") as container:
            stream = container.add_stream("libx264", rate=25, options={"crf": "30"})
            stream.width, stream.height, stream.pix_fmt = first.width, first.height, "yuv420p"
            container.mux(stream.encode(av.VideoFrame.from_ndarray(first.to_ndarray(), "yuv420p")))
            container.mux(stream.encode())
    assert not tell_other_films(codes_of(tmp_path, **again), known)
    a, b = films[0].stem, films[1].stem
    renamed = again | {a: shutil.copy(again[b], tmp_path / "x.mp4"), b: again[a]}
    said = tell_other_films(codes_of(tmp_path, **renamed), known)
    assert [text.split()[4] for text in said] == [a, b]  # the clicks of view ...
