"""How a solve is run: `LmConfig`."""

from __future__ import annotations

import difflib
import math
import numbers
import operator
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Literal, cast

from arael.diagnostics.records import AraelError, Diagnostic

Observer = Callable[[Any], bool | None]
Driver = Callable[[Any], float | None]

# Smallest lambda by precision: below it damping is lost in the rounding of the diagonal.
FLOOR_F64 = 1e-12
FLOOR_F32 = 1.2e-7

# Default of `rel_precision`, and that of problems of up to so many unknowns in f64.
REL_PRECISION = 1e-10
REL_PRECISION_SMALL = 1e-14
SMALL = 32


@dataclass(frozen=True)
class LmConfig:
    """Settings of a solve.

    The cost is the sum of squared residuals, without 1/2. The *predicted decrease* is what the
    linear model promises of an undamped step, ``g' (J'J)^-1 g``: no step can promise more.

    Attributes
    ----------
    abs_precision :
        Predicted decrease of the cost at or below which a solve has converged; 0: off, because a
        useful value depends on the units of the residuals.
    rel_precision :
        The same as a fraction of the cost. None: 1e-10; where no connected component has more than
        32 unknowns, so that an attempt takes microseconds, the dogleg in f64 goes on to 1e-14 as
        long as steps succeed, which gives a fit six digits or more. 1e-4 for a real-time pass that
        needs a good enough answer. A predicted decrease below the rounding noise of the cost
        (`Result.noise_floor`) always counts as none.
    max_iters :
        Maximum number of attempts, including rejected ones, of each connected component of the
        problem. About twice the number that the trace shows.
    min_iters :
        Accepted steps before the solve may have converged.
    patience :
        Number of accepted steps before the current one that must have met the precision too.
    initial_lambda :
        First damping of the damped strategy. 1e-6 for a warm start, 1e-2 or more for a start far
        from the solution.
    lambda_floor :
        Smallest damping, and smallest regularisation of the dogleg; None: 1e-12 in f64, 1.2e-7 in
        f32. Raise it if factorisation keeps failing at small lambda.
    lambda_ceiling :
        The solve ends when a rejection would raise lambda above this.
    retry_budget :
        Maximum number of retries with one linearisation; 0: no limit.
    cost_threshold :
        The solve ends when the total cost is at or below this; 0: off. For feasibility problems.
    gradient_tolerance :
        The solve ends when no entry of the gradient 2 J'r is larger; 0: off.
    parameter_tolerance :
        The solve ends when ``|step| <= tolerance (|x| + tolerance)``; 0: off.
    predicted_reduction_tolerance :
        The solve ends when the predicted decrease of the step, as damped or restricted to the trust
        region, is at most this fraction of the cost; 0: off.
    min_diagonal :
        Lower bound of the undamped diagonal of J'J; 0: off. With it, unconstrained parameters keep
        their values instead of being an error.
    time_limit :
        Seconds after which no further attempt begins; None: no limit.
    num_threads :
        Threads of a solve, including the calling thread; 0: one per core. At most 64 are used.
        They share linearisation,
        cost and linear algebra if each share takes long enough; small problems always run on one
        thread. Results are the same bit for bit on any number of threads, except for
        factorisations by BLAS: `lapack_band`, `cholmod`, very wide bands, and without AVX2 very
        large dense systems.
    verbose :
        One line per attempt on stderr. Use it first if a solve fails or is slow.
    observer :
        Called with the record of each attempt (fields: see `Result.history`); returning False
        ends the solve with the best state so far.
    damping :
        How lambda changes in the damped strategy: ``"gain"`` (Nielsen's rule of the ratio of actual
        to predicted decrease, falling by up to 10, on the largest diagonal so far), ``"nielsen"``
        (the same, falling by up to 3, on the current diagonal), ``"ladder"`` (times 0.2 after
        success, times 10 after failure), or a callable that takes the record of an attempt and
        returns the next lambda, None to end the solve.
    strategy :
        ``"dogleg"``: a trust region with Powell's dogleg. ``"damped"``: Levenberg-Marquardt.
        ``"auto"``: ``damped`` if `damping`, `initial_lambda`, `lambda_floor`, `lambda_ceiling` or
        `retry_budget` differs from its default; ``damped`` by the ladder with the approximate
        steps of the linear solver ``schur_pcg``; else ``dogleg``, which gives way to damped steps
        with inner iterations where it fails and the linear solver ``schur`` eliminates entities.
    ending :
        ``"promise"``: a solve has converged when the predicted decrease is below the precisions or
        the rounding noise of the cost. ``"small_steps"``, the rule of the reference framework: when
        the last ``patience + 1`` accepted steps lowered the cost by less than `abs_precision`, or
        by less than the fraction `rel_precision`, after `min_iters` accepted steps.
    """

    abs_precision: float = 0.0
    rel_precision: float | None = None
    max_iters: int = 500
    min_iters: int = 0
    patience: int = 0
    initial_lambda: float = 1e-4
    lambda_floor: float | None = None
    lambda_ceiling: float = 1e12
    retry_budget: int = 0
    cost_threshold: float = 0.0
    gradient_tolerance: float = 0.0
    parameter_tolerance: float = 0.0
    predicted_reduction_tolerance: float = 0.0
    min_diagonal: float = 0.0
    time_limit: float | None = None
    num_threads: int = 1
    verbose: bool = False
    observer: Observer | None = None
    damping: Literal["gain", "ladder", "nielsen"] | Driver = "gain"
    strategy: Literal["auto", "dogleg", "damped"] = "auto"
    ending: Literal["promise", "small_steps"] = "promise"

    def __post_init__(self) -> None:
        # NumPy's scalars become Python's, so that the checks and the loop see one type of each.
        for name in (*_COUNTS, *_NOT_NEGATIVE, *_OPTIONAL, "lambda_ceiling", "verbose"):
            object.__setattr__(self, name, _plain(getattr(self, name)))

    @classmethod
    def of(cls, **settings: Any) -> LmConfig:
        """A checked configuration from settings by name; AraelError E1010 for a bad one."""
        return (_DEFAULT if cls is LmConfig else cls()).with_(**settings)

    @classmethod
    def well_conditioned(cls, **settings: Any) -> LmConfig:
        """Start near the solution of a problem that is close to linear: warm starts, small updates.

        The first step is a Gauss-Newton step, as by default; the solve ends as soon as the
        predicted decrease is below a millionth of the cost, often after one or two steps.
        """
        return cls(rel_precision=1e-6).with_(**settings)

    @classmethod
    def ill_conditioned(cls, **settings: Any) -> LmConfig:
        """Long shallow valleys, or parameters of very different sensitivity.

        The trust region, whose scaling limits steps of parameters that lose their effect; a tight
        precision and many attempts, so that a valley is followed to its end.
        """
        return cls(strategy="dogleg", rel_precision=1e-14, max_iters=2000).with_(**settings)

    @classmethod
    def conservative(cls, **settings: Any) -> LmConfig:
        """Prefer reliability to speed: damped from the start, more damping, tight precision."""
        return cls(
            strategy="damped",
            initial_lambda=1e-3,
            lambda_floor=1e-8,
            max_iters=1000,
            patience=2,
            rel_precision=1e-14,
        ).with_(**settings)

    @classmethod
    def reference(cls, **settings: Any) -> LmConfig:
        """The loop of the reference framework: its eight fields with its defaults.

        Levenberg-Marquardt with the ladder of damping, ended by small steps. For comparisons, and
        for programs that were tuned to it; `docs/from_rust.md` has the table.
        """
        return cls(
            abs_precision=1e-6,
            rel_precision=1e-4,
            max_iters=100,
            min_iters=5,
            patience=3,
            initial_lambda=1e-4,
            damping="ladder",
            strategy="damped",
            ending="small_steps",
        ).with_(**settings)

    def with_(self, **settings: Any) -> LmConfig:
        """A checked copy with some settings changed; AraelError E1010 for unknown or bad ones."""
        if not settings and self.__dict__.get("_checked"):
            return self  # frozen, and no check needs repeating
        observer = settings.get("observer")
        if callable(observer):  # a function of each call: all else is checked and known as without
            rest = {name: value for name, value in settings.items() if name != "observer"}
            return self.with_(**rest)._observed_by(observer)
        # 1, 1.0 and True are equal, but not equally valid.
        key = tuple((name, type(value), value) for name, value in settings.items())
        made = self.__dict__.setdefault("_made", {})
        plain = all(kind in _PLAIN for _, kind, _ in key)
        if plain and (known := made.get(key)) is not None:  # one access: another thread may clear
            return cast(LmConfig, known)
        for name in settings:
            if name not in _NAMES:
                near = difflib.get_close_matches(name, _NAMES, 1)
                raise _refused(
                    f"there is no solver setting `{name}`",
                    f"did you mean `{near[0]}`?" if near else f"there are: {', '.join(_NAMES)}",
                )
        found = replace(self, **settings) if settings else self
        found.validate()
        object.__setattr__(found, "_checked", True)
        if plain and found is not self:
            if len(made) >= _MOST_MADE:
                made.clear()
            made[key] = found
        return found

    def _observed_by(self, observer: Observer) -> LmConfig:
        """A copy of a checked configuration with another observer, which is callable."""
        self.chosen_strategy()  # kept here, or each copy would find it anew
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__, observer=observer)
        found.__dict__.pop("_made", None)
        return found

    def chosen_strategy(self) -> str:
        """The strategy used with a direct linear solver: `strategy`, with ``auto`` resolved."""
        if self.strategy != "auto":
            return self.strategy
        return self._automatic

    @cached_property
    def _automatic(self) -> str:
        changed = any(getattr(self, name) != getattr(_DEFAULT, name) for name in _OF_DAMPING)
        return "damped" if changed else "dogleg"

    def floor(self, single: bool) -> float:
        """Smallest lambda in f32 (`single`) or f64."""
        if self.lambda_floor is not None:
            return self.lambda_floor
        return FLOOR_F32 if single else FLOOR_F64

    def relative(self, size: int, single: bool) -> float:
        """Value of `rel_precision` for a problem of `size` unknowns in f32 (`single`) or f64."""
        if self.rel_precision is not None:
            return self.rel_precision
        size = self.__dict__.get("_largest", size)
        small = size <= SMALL and not single and self.chosen_strategy() != "damped"
        return REL_PRECISION_SMALL if small else REL_PRECISION

    def for_components(self, largest: int) -> LmConfig:
        """A copy for a problem whose largest connected component has so many unknowns.

        Components that are solved apart end as they would alone.
        """
        found = object.__new__(type(self))
        kept = {name: value for name, value in self.__dict__.items() if name != "_made"}
        found.__dict__.update(kept, _largest=largest)
        return found

    @property
    def enough(self) -> float:
        """Predicted decrease, as a fraction of the cost, that need not be realised."""
        return REL_PRECISION if self.rel_precision is None else self.rel_precision

    def validate(self) -> None:
        """Raise AraelError (E1010) naming the first setting that makes no sense."""
        for name in _NOT_NEGATIVE:
            value = getattr(self, name)
            if not _is_number(value) or not value >= 0 or math.isinf(value):
                raise _refused(f"`{name}` is {value!r}", "it must be a number, zero or more")
        for name, least in _COUNTS.items():
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or not least <= value < 2**31:
                raise _refused(
                    f"`{name}` is {value!r}", f"it must be a whole number from {least} on"
                )
        for name in _OPTIONAL:
            value = getattr(self, name)
            if value is not None and (not _is_number(value) or not value >= 0):
                raise _refused(
                    f"`{name}` is {value!r}", f"it must be {_OR_NONE}a number, zero or more"
                )
        if not _is_number(self.lambda_ceiling) or not self.lambda_ceiling > self.initial_lambda:
            raise _refused(
                f"`lambda_ceiling` is {self.lambda_ceiling!r}",
                f"it must be above initial_lambda ({self.initial_lambda:g})",
            )
        if not isinstance(self.verbose, bool):
            raise _refused(f"`verbose` is {self.verbose!r}", "it must be true or false")
        named = isinstance(self.damping, str) and self.damping in _DAMPINGS
        if not named and not callable(self.damping):
            raise _refused(
                f"`damping` is {self.damping!r}",
                f"it must be {_listed(_DAMPINGS)} or a callable",
            )
        for name, words in _WORDS.items():
            value = getattr(self, name)
            if not isinstance(value, str) or value not in words:
                raise _refused(f"`{name}` is {value!r}", f"it must be {_listed(words)}")
        if self.strategy not in ("auto", "damped") and self.damping != "gain":
            raise _refused(
                f"`strategy` is {self.strategy!r}, which has no use for `damping` {self.damping!r}",
                'set strategy="damped", or leave one of the two out',
            )
        if self.observer is not None and not callable(self.observer):
            raise _refused(f"`observer` is {self.observer!r}", "it must be callable")


def refused(name: str, value: object) -> str:
    """Why a pass cannot give the setting `name` this value; "" if it can.

    A model file has no None: settings that may be None in Python keep their default there.
    """
    try:
        replace(LmConfig(), **{name: value}).validate()  # type: ignore[arg-type]
    except AraelError as error:
        (found,) = error.diagnostics
        return found.help[0].replace(_OR_NONE, "") if found.message.startswith(f"`{name}` ") else ""
    return ""


_NOT_NEGATIVE = (
    "abs_precision",
    "initial_lambda",
    "cost_threshold",
    "gradient_tolerance",
    "parameter_tolerance",
    "predicted_reduction_tolerance",
    "min_diagonal",
)
_OR_NONE = "None or "
_OPTIONAL = ("rel_precision", "lambda_floor", "time_limit")
_DAMPINGS = ("gain", "ladder", "nielsen")
_WORDS = {
    "strategy": ("auto", "dogleg", "damped"),
    "ending": ("promise", "small_steps"),
}
# Changing one of these selects the damped strategy.
_OF_DAMPING = ("damping", "initial_lambda", "lambda_floor", "lambda_ceiling", "retry_budget")
_COUNTS = {"max_iters": 1, "min_iters": 0, "patience": 0, "retry_budget": 0, "num_threads": 0}


def _listed(words: tuple[str, ...]) -> str:
    return ", ".join(f'"{word}"' for word in words)


def _plain(value: Any) -> Any:
    """A number or truth value of any library as Python's own; anything else as it is."""
    if type(value) in (bool, int, float, type(None)):
        return value
    if type(value).__name__ in ("bool", "bool_") and hasattr(value, "dtype"):
        return bool(value)
    try:
        return operator.index(value)
    except TypeError:
        return float(value) if isinstance(value, numbers.Real) else value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _refused(message: str, help_text: str) -> AraelError:
    return AraelError(Diagnostic("E1010", message, origin="LmConfig", help=(help_text,)))


_NAMES = tuple(f.name for f in fields(LmConfig))

# Copies with changed settings are kept with a configuration, at most so many: a program that solves
# again and again passes the same ones. Values of other types than these may keep objects alive.
_PLAIN = (bool, int, float, str, type(None))
_MOST_MADE = 32

_DEFAULT = LmConfig()
