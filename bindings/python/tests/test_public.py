"""What the wheel keeps (docs/compatibility.md): names and signatures of `erard.__all__`, in `public.txt`.

`python tests/test_public.py FILE` writes the file (`.ci/regenerate wheel-public`).
"""

import inspect
import sys
from pathlib import Path

import erard

KEPT = Path(__file__).resolve().parents[1] / "public.txt"


def signature(of):
    """Parameters with their kinds and defaults; annotations are the stubs' (`_erard.pyi`), which mypy compares."""
    try:
        parameters = inspect.signature(of).parameters.values()
    except (TypeError, ValueError):
        return "(...)"
    return f"({', '.join(_parameters(parameters))})"


def _parameters(parameters):
    before = None
    for one in parameters:
        if before is inspect.Parameter.POSITIONAL_ONLY and one.kind is not before:
            yield "/"
        if one.kind is inspect.Parameter.KEYWORD_ONLY and before not in (one.kind, inspect.Parameter.VAR_POSITIONAL):
            yield "*"
        before = one.kind
        stars = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}.get(one.kind, "")
        # A default that is an object of its own has an address in its text.
        shown = repr(one.default)
        default = "" if one.default is inspect.Parameter.empty else f"={'...' if ' at 0x' in shown else shown}"
        yield f"{stars}{one.name}{default}"
    if before is inspect.Parameter.POSITIONAL_ONLY:
        yield "/"


def members(of):
    """Public members of a class that the package itself defines, each a line."""
    own = {name: member for base in reversed(of.__mro__) if base.__module__.partition(".")[0] == "erard" for name, member in vars(base).items()}
    for name, member in sorted(own.items()):
        if name.startswith("_"):
            continue
        plain = getattr(member, "__func__", member)
        if isinstance(member, property) or inspect.isdatadescriptor(member):
            yield f"{of.__name__}.{name}"
        elif callable(plain):
            yield f"{of.__name__}.{name}{signature(plain)}"
        else:
            yield f"{of.__name__}.{name}"
    # Fields of records that have no default are in no namespace.
    for name in sorted(set(getattr(of, "__dataclass_fields__", ())) - set(own)):
        if not name.startswith("_"):
            yield f"{of.__name__}.{name}"


def text():
    lines = []
    for name in sorted(erard.__all__):
        it = getattr(erard, name)
        if inspect.isclass(it):
            bases = ", ".join(base.__name__ for base in it.__bases__ if base is not object)
            lines.append(f"class {name}({bases})" if bases else f"class {name}")
            # Of exceptions, how they are raised is nobody's business.
            lines += [] if issubclass(it, BaseException) else [f"{name}{signature(it)}"]
            lines += members(it)
        elif callable(it):
            lines.append(f"{name}{signature(it)}")
        else:
            lines.append(f"{name}: {type(it).__name__}")
    return "".join(f"{line}\n" for line in lines)


def test_the_list_is_that_of_the_package():
    kept, now = KEPT.read_text(encoding="utf-8").splitlines(), text().splitlines()
    gone = [f"- {line}" for line in kept if line not in now]
    new = [f"+ {line}" for line in now if line not in kept]
    told = "\n".join(["bindings/python/public.txt is stale: `.ci/regenerate wheel-public` rewrites it; docs/compatibility.md", *gone, *new])
    assert kept == now, told


def test_a_change_is_seen():
    def kept(a, /, b=1, *rest, c, d=None, **more):
        del a, b, rest, c, d, more

    def changed(a, /, b=2, *, c):
        del a, b, c

    assert signature(kept) == "(a, /, b=1, *rest, c, d=None, **more)"
    assert signature(changed) == "(a, /, b=2, *, c)"
    lines = text().splitlines()
    assert len(lines) > 2 * len(erard.__all__) and any(line.startswith("Action.step(") for line in lines), lines


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(text(), encoding="utf-8")
