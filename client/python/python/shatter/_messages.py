"""Messages for names that do not exist: attributes, and keywords of calls."""

import difflib
import functools
import inspect
from collections.abc import Callable
from types import ModuleType
from typing import Any

# Other words for attributes and keywords, with what they mean.
_OTHER = {
    "fragments": "the result is a sequence of its fragments: `for fragment in result`, `result[0]`, `len(result)`",
    "effects": "effects are switched by `enable=[…]` and `disable=[…]`",
    **dict.fromkeys(
        ["point", "impulse", "contact", "contacts", "ray", "radius", "duration_s"],
        "contacts come first, without a keyword: `strike(shatter.Contact(point, impulse))`",
    ),
}


def _suggestion(name: str, known: list[str], all_are: str) -> str:
    """The likely meaning of ``name``, then all names."""
    likely = difflib.get_close_matches(name, known, n=3)
    named = [", ".join(f"`{other}`" for other in names) for names in (likely, known)]
    meant = f"did you mean {named[0]}?" if likely else _OTHER.get(name, "")
    return f"{meant}{'; ' if meant else ''}{all_are} {named[1]}"


def _missing(self: object, name: str) -> Any:
    kind = type(self).__name__
    message = f"{kind!r} has no attribute {name!r}"
    if not name.startswith("_"):
        known = [known for known in dir(type(self)) if not known.startswith("_")]
        message += "; " + _suggestion(name, known, "it has")
    raise AttributeError(message)


def _explained(function: Callable[..., Any]) -> Callable[..., Any]:
    """``function``, with an error that lists the keywords if one does not exist."""
    parameters = inspect.signature(function).parameters.values()
    known = [parameter.name for parameter in parameters if parameter.kind != parameter.VAR_POSITIONAL]
    known = [name for name in known if name not in ("self", "cls")]

    @functools.wraps(function)
    def call(*arguments: Any, **keywords: Any) -> Any:
        if unknown := [name for name in keywords if name not in known]:
            name = unknown[0]
            message = f"{function.__name__}() has no argument {name!r}; {_suggestion(name, known, 'its keywords are')}"
            raise TypeError(message)
        return function(*arguments, **keywords)

    return call


def explain(module: ModuleType) -> None:
    """Replaces the errors for attributes and keywords that do not exist, in all classes and functions of ``module``."""
    for name, value in list(vars(module).items()):
        if inspect.isbuiltin(value):
            setattr(module, name, _explained(value))
        if not inspect.isclass(value) or issubclass(value, BaseException):
            continue
        setattr(value, "__getattr__", _missing)
        for key, method in list(vars(value).items()):
            # A method without parameters has no keywords.
            if inspect.ismethoddescriptor(method) and not key.startswith("_") and len(inspect.signature(method).parameters) > 1:
                setattr(value, key, _explained(method))
