"""Steps are counted from any thread and told from one."""

import threading

from pawnb.core.pose.fit.steps import Steps


def in_thread(work):
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()


def test_steps_of_other_threads_count_and_are_told_by_the_first():
    told = []
    steps = Steps(5, lambda done, total: told.append((done, total, threading.get_ident())))
    steps.one()
    in_thread(lambda: [steps.one() for _ in range(3)])
    assert told == [(1, 5, threading.get_ident())]
    steps.one()
    steps.one()  # more than there are is not told
    steps.end()
    assert [(done, total) for done, total, _ in told] == [(1, 5), (5, 5), (5, 5), (5, 5)]
    assert {who for *_, who in told} == {threading.get_ident()}


def test_work_stops_when_asked_and_when_something_went_wrong():
    asked = False
    steps = Steps(3, None, lambda: asked)
    assert not steps.stopped()
    asked = True
    assert steps.stopped()
    steps = Steps(3)
    steps.one()
    assert not steps.stopped()
    in_thread(steps.halt)
    assert steps.stopped()


def test_what_was_stopped_is_not_said_to_be_done():
    told = []
    steps = Steps(3, lambda *now: told.append(now), lambda: True)
    steps.end()
    assert not told
