"""Solving: options as on the command line, progress, interruptions."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any, Callable, Iterable, List, Optional, Union

from . import _core
from ._result import Result
from ._scene import Scene


@dataclass(frozen=True)
class Progress:
    """Progress of a run, passed to the callback several times a second."""

    #: Share of the work done, 0 to 1.
    fraction: float
    #: Largest stated error of the maps to which the target applies, once all of them have been judged.
    estimated_error: Optional[float]
    #: Target, if one is set.
    target_error: Optional[float]
    #: Rays so far.
    rays: int
    #: Chains so far.
    chains: int
    #: Forecast of the remaining seconds, if there is one.
    remaining_s: Optional[float]
    #: Seconds since the run began.
    elapsed_s: float

    def __str__(self) -> str:
        words: List[str] = []
        if self.estimated_error is not None:
            words.append(f"error {100 * self.estimated_error:.3g} %")
        if self.target_error is not None:
            words.append(f"target {100 * self.target_error:.3g} %")
        if self.remaining_s is not None:
            words.append(f"{self.remaining_s:.1f} s left")
        words.append(f"{self.rays / 1e6:.3g} M rays")
        return ", ".join(words)


Callback = Callable[[Progress], Any]

#: Seconds between two progress lines if tqdm is not installed.
_LINE_EVERY_S = 2.0


class _Bar:
    """Progress bar of tqdm, or occasional lines if tqdm is not installed."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._told_s = time.monotonic()
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return
        layout = "{l_bar}{bar}| {elapsed}{postfix}"
        self._bar = tqdm(total=1.0, desc="luxmc", bar_format=layout)

    def __call__(self, progress: Progress) -> None:
        if self._bar is not None:
            self._bar.n = min(max(progress.fraction, 0.0), 1.0)
            self._bar.set_postfix_str(str(progress))
        elif time.monotonic() - self._told_s > _LINE_EVERY_S:
            self._told_s = time.monotonic()
            print(f"luxmc: {100 * progress.fraction:.0f} %: {progress}", file=sys.stderr)

    def close(self, result: Optional[Result]) -> None:
        if self._bar is None:
            return
        if result is not None:
            self._bar.n = 1.0
            self._bar.set_postfix_str(result.closing_words.splitlines()[0])
        self._bar.close()


def solve(
    scene: Scene,
    *,
    target_error: Union[float, str, None] = None,
    time_limit: Union[float, str, None] = None,
    chains: Union[int, str, None] = None,
    maps: Union[str, Iterable[str], None] = None,
    method: str = "auto",
    elements: str = "adaptive",
    seed: int = 0,
    threads: Optional[int] = None,
    progress: Union[bool, Callback] = False,
) -> Result:
    """Computes the maps of a scene; the options are those of ``luxmc solve``.

    The run ends at the first of ``target_error`` (a fraction or ``"1%"``; 1 % where no stop rule is given), ``time_limit`` (seconds
    from this call, or ``"5m"``) and ``chains``. A fixed number of chains gives the same bytes as the command line, on any number of
    threads.

    The solver releases the interpreter's lock. ``progress=True`` shows a progress bar (tqdm, if it is installed). A function given as
    ``progress`` is called with a ``Progress`` several times a second. A KeyboardInterrupt ends the run and keeps the results so far;
    the stop reason is then ``"interrupted"``. An exception in the callback also ends the run, and is raised.

    >>> import luxmc
    >>> scene = luxmc.Scene(
    ...     materials={"paint": {"type": "diffuse", "reflectance": 0.5}},
    ...     geometry=[{"name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint"}],
    ...     luminaires=[{"name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000}],
    ...     receivers=[{"name": "desk", "type": "grid", "surface": "room/floor", "height": 0.75, "spacing": 0.5}])
    >>> result = luxmc.solve(scene, target_error=0.02, seed=1)
    >>> result.target_met, bool(result.estimated_error <= 0.02)
    (True, True)
    >>> luxmc.solve(scene, target_error=2)
    Traceback (most recent call last):
        ...
    luxmc.RefusedError: invalid value for target_error
      got:      "2"
      expected: a value that --target-error of luxmc solve accepts
      remedy:   100% or more is no target; write a relative error above 0 and below 1, such as 1% or 0.01
    """
    given = {
        "target_error": target_error,
        "time_limit": time_limit,
        "chains": chains,
        "maps": maps if maps is None or isinstance(maps, str) else ",".join(maps),
        "method": method,
        "elements": elements,
        "seed": seed,
        "threads": threads,
    }
    options = {name: str(value) for name, value in given.items() if value is not None}
    bar = _Bar() if progress is True else None
    tell: Optional[Callback] = bar if bar is not None else progress if callable(progress) else None

    def listener(
        fraction: float,
        estimated: Optional[float],
        target: Optional[float],
        rays: int,
        counted: int,
        remaining_s: Optional[float],
        elapsed_s: float,
    ) -> None:
        if tell is not None:
            tell(Progress(fraction, estimated, target, rays, counted, remaining_s, elapsed_s))

    result: Optional[Result] = None
    try:
        solution = _core.solve(scene._core, options, _command(scene, given), listener if tell is not None else None)
        result = Result(scene, solution)
    finally:
        if bar is not None:
            bar.close(result)
    return result


def _command(scene: Scene, given: dict[str, Any]) -> str:
    """The Python call that repeats the run, for the report."""
    usual = {"method": "auto", "elements": "adaptive", "threads": None}
    told = [f"{name}={value!r}" for name, value in given.items() if value is not None and usual.get(name) != value]
    return f"luxmc.solve(luxmc.Scene.load({scene.name!r}), {', '.join(told)})"
