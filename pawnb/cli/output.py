"""What a command says, to readers that may leave before it ends."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

# what a pipe without a reader answers, the second on Windows
_NO_READER = (errno.EPIPE, errno.EINVAL)


class _Output:
    """A stream; the work goes on when its reader has left, or cannot take a sign of a name."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write text."""
        with self._reader_may_have_left():
            try:
                self._stream.write(text)
            except UnicodeEncodeError as error:  # into a file on Windows, 8 bits a sign
                plain = text.encode(error.encoding, "backslashreplace").decode(error.encoding)
                self._stream.write(plain)
        return len(text)

    def flush(self) -> None:
        """Write what is waiting."""
        with self._reader_may_have_left():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @contextmanager
    def _reader_may_have_left(self) -> Iterator[None]:
        """Turn the stream away from a pipe that nobody reads."""
        try:
            yield
        except OSError as error:
            if error.errno not in _NO_READER:
                raise
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)


@contextmanager
def readers_may_leave() -> Iterator[None]:
    """Let whoever reads what a command says leave, as ``head`` and ``true`` do."""
    out, errors = _Output(sys.stdout), _Output(sys.stderr)
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            yield
        finally:
            out.flush()
            errors.flush()
