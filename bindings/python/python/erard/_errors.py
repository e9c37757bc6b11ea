"""The errors that this package raises, and where each comes from."""

from __future__ import annotations


#: Of a longer text only the beginning and the end are shown, so many characters of each.
_SHOWN = 400


def shortened(text: str) -> str:
    """The text, or its beginning and its end where it is long: nobody reads a million digits."""
    if len(text) <= 2 * _SHOWN:
        return text
    return f"{text[:_SHOWN]} ... ({len(text) - 2 * _SHOWN} characters left out) ... {text[-_SHOWN:]}"


class Extra:
    """A block of imports that an extra of the package brings along: where one is missing, the error says how to install it."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, ModuleNotFoundError):
            told = f"{error.name} is not installed: pip install 'erard[{self._name}]' brings it along"
            raise ModuleNotFoundError(told, name=error.name) from error


class InputError(ValueError):
    """Something that was given is wrong: a name, a number, an array, a file.

    Attributes
    ----------
    file : str or None
        The file in which it stands.
    line : int or None
        The line of it, from 1 (of a table without lines: the row).
    key : str or None
        The key, column or argument that is meant.
    found : str or None
        What stands there.
    expected : str or None
        What should stand there.

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
    """A fit has doubts (`Fit.doubts`): do not use its numbers before you have read them."""


class MissingFileError(InputError, FileNotFoundError):
    """A file that is not there, or cannot be read. It is a `FileNotFoundError`, too."""

    def __str__(self) -> str:
        return str(self.args[0])


class SimulationError(RuntimeError):
    """A simulation came to no result: a number became infinite, or there is no rest to start from."""
