"""Errors and warnings of this package."""

from __future__ import annotations


#: Number of characters shown of the beginning and of the end of a longer text.
_SHOWN = 400


def shortened(text: str) -> str:
    """Returns the text, shortened to its beginning and its end if it is long."""
    if len(text) <= 2 * _SHOWN:
        return text
    return f"{text[:_SHOWN]} ... ({len(text) - 2 * _SHOWN} characters left out) ... {text[-_SHOWN:]}"


class Extra:
    """Context for imports from an extra of the package: if one is missing, the error says how to install it."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, ModuleNotFoundError):
            told = f"{error.name} is not installed: pip install 'erard[{self._name}]' brings it along"
            raise ModuleNotFoundError(told, name=error.name) from error


class InputError(ValueError):
    """Invalid input: a name, a number, an array or a file.

    Attributes
    ----------
    file : str or None
        File that holds the error.
    line : int or None
        Line in the file, from 1 (in a table without lines: the row).
    key : str or None
        Key, column or argument that is wrong.
    found : str or None
        Value that was found.
    expected : str or None
        Value that is expected.

    Examples
    --------
    >>> import erard
    >>> try:
    ...     erard.load("concert-grand").vary(let_off="1 g")
    ... except erard.InputError as error:
    ...     error.key, error.found
    ('let_off', '1 g')
    """

    file: str | None
    line: int | None
    key: str | None
    found: str | None
    expected: str | None

    def __init__(
        self,
        message: str,
        file: str | None = None,
        line: int | None = None,
        key: str | None = None,
        found: str | None = None,
        expected: str | None = None,
    ) -> None:
        message = shortened(str(message))
        found, key = (None if text is None else shortened(str(text)) for text in (found, key))
        super().__init__(message, file, line, key, found, expected)
        self.file, self.line, self.key, self.found, self.expected = file, line, key, found, expected

    def __str__(self) -> str:
        return str(self.args[0])


class DoubtfulFitWarning(UserWarning):
    """Doubtful fit: read `Fit.doubts` before you use its results."""


class FailedStrokesWarning(UserWarning):
    """Strokes without results among many: their rows are nan, and the column `error` holds the reasons."""


class MissingFileError(InputError, FileNotFoundError):
    """Missing or unreadable file; also a `FileNotFoundError`."""

    def __str__(self) -> str:
        return str(self.args[0])


class SimulationError(RuntimeError):
    """Simulation without a result: a number became infinite, or the action has no rest to start from."""
