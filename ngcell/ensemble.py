"""Members of a case, one run after the other, and how much of each number they have in common.

Each member is a run like any other, in a folder of its own. One that fails is a member with a named outcome, and does
not count in a mean.
"""

from __future__ import annotations

import gc
from collections.abc import Generator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from time import monotonic
from typing import Any

from ngcell.errors import CaseError, NotConverged, OutputError
from ngcell.export import (
    EnsembleFolder,
    accepted_steps,
    cannot_resume,
    read_records,
    read_summary,
    restore_case,
    spread_table,
)
from ngcell.export.summary import CASE_TEXT, MEMBERS, failed_checks
from ngcell.recording import RecordingOptions
from ngcell.results.record import StepRecord
from ngcell.results.spread import REFUSED, Member, Spread, at_levels, spreads
from ngcell.run import record, resume
from ngcell.scene import AnyCase, Case, read_case, resolved_toml
from ngcell.scene.members import MemberChoice, check_has_members, geometry_share, member_of
from ngcell.solve.outcome import Outcome


class Ensemble:
    """Members of a case: iterate over it to run them.

    Parameters
    ----------
    case : Case or BodyCase
        What members are made from: a case of a tissue.
    out : Path
        The folder of all of them.
    choice : MemberChoice
        How many, from which seed, how different.
    options : RecordingOptions
        How each is recorded; the time is that of all together.
    resumed : bool
        Whether they have been begun in this folder before: those that have ended are read and not run again.

    Attributes
    ----------
    members : list of Member
        Those that have ended.
    spreads : list of Spread
        Mean and spread of each number at each level, over members that are certified there.

    Raises
    ------
    CaseError
        The geometry of the scene cannot be varied.
    NotConverged
        While iterating: the time is over. What was run is kept.
    OutputError
        While iterating: a folder cannot be used or written.
    """

    def __init__(
        self,
        case: AnyCase,
        out: Path,
        choice: MemberChoice,
        options: RecordingOptions | None = None,
        *,
        resumed: bool = False,
    ) -> None:
        self.case, self.out, self.choice = check_has_members(case, choice.spread), Path(out), choice
        self._options, self._resumed = options or RecordingOptions(), resumed
        self.members: list[Member] = []
        self.spreads: list[Spread] = []

    @property
    def share(self) -> float:
        """Share of a side, or of a wall's thickness, by which members differ at most; infinite if nobody knows."""
        return self._varied[0]

    @property
    def _varied(self) -> tuple[float, float]:
        return geometry_share(self.case, self.choice.spread)

    @property
    def certified(self) -> bool:
        """Whether every member is certified."""
        return len(self.members) == self.choice.count and all(member.certified for member in self.members)

    def __iter__(self) -> Generator[tuple[int, StepRecord], None, None]:
        """Yield the accepted steps of members that are run, each with the number of its member."""
        factors, options = self.case.level_factors, self._options
        end, told = options.end, asdict(self.choice)
        folder = EnsembleFolder(
            self.out,
            case_text=resolved_toml(self.case),
            told=told,
            force=options.force,
            resumed=self._resumed,
            pictures=options.pictures,
        )
        with folder:
            for number, seed in enumerate(self.choice.seeds):
                member = self._ended(folder, number, seed)
                if member is None:
                    member = yield from self._run(folder, number, seed, end)
                else:
                    folder.count(_steps_in(folder.member(number)))
                self.members.append(member)
                self.spreads = spreads(self.members, factors, *self._varied)
                folder.keep(self.members, self.spreads, factors)
                gc.collect()  # a scene is held by reference cycles, and the next one needs the memory
            folder.finish(self.members, self.spreads, self._summary())

    def _run(
        self, folder: EnsembleFolder, number: int, seed: int, end: float | None
    ) -> Generator[tuple[int, StepRecord], None, Member]:
        """Run a member, or what is left of it, and return it."""
        out, factors = folder.member(number), self.case.level_factors
        try:
            case = member_of(self.case, seed, self.choice.spread)
        except CaseError as error:
            return _refused(number, seed, error, len(factors))
        how = self._how(number, end)
        is_rest, accepted = self._resumed and _has_begun(out, case), False
        folder.count(_steps_in(out) if is_rest else 0)
        recording = resume(out, **how) if is_rest else record(case, out, force=self._replaces, **how)
        try:
            for step in recording:
                accepted = True
                folder.count(1)
                yield number, step
        except CaseError as error:
            return _refused(number, seed, error, len(factors), "stopped" if is_rest or accepted else REFUSED)
        except NotConverged as error:
            if error.outcome == Outcome.OUT_OF_TIME.name:
                raise _out_of_time(number) from error
        history = read_records(out / "history.csv", StepRecord) if is_rest or accepted else []
        return _member(number, seed, recording.summary, history, factors)

    def _ended(self, folder: EnsembleFolder, number: int, seed: int) -> Member | None:
        """Return a member that ended before the stop; None where it has to be run."""
        if not self._resumed:
            return None
        out = folder.member(number)
        with suppress(CaseError, OutputError):
            case = member_of(self.case, seed, self.choice.spread)
            summary = read_summary(out)
            if summary.get("status") == "finished" and _is_of(out, case):
                history = read_records(out / "history.csv", StepRecord)
                return _member(number, seed, summary, history, self.case.level_factors)
        return None

    @property
    def _replaces(self) -> bool:
        """Whether a member may replace what is in its folder: what an earlier run with other members has left."""
        return self._options.force or self._resumed

    def _how(self, number: int, end: float | None) -> dict[str, Any]:
        """Return how a member is recorded that begins now."""
        minutes = None if end is None else (end - monotonic()) / 60
        if minutes is not None and minutes <= 0:
            raise _out_of_time(number)
        return {"threads": self._options.threads, "max_minutes": minutes, "pictures": self._options.pictures}

    def _summary(self) -> dict[str, Any]:
        """Return what `summary.json` holds of all members."""
        ended = [
            {"seed": one.seed, "certified": one.certified, "outcome": one.outcome, "folder": f"member_{one.number:03d}"}
            for one in self.members
        ]
        return {
            "title": self.case.title,
            "certified": self.certified,
            "outcome": f"{sum(one.certified for one in self.members)} of {len(self.members)} members are certified",
            "members_ended": ended,
            "spread": spread_table(self.spreads),
        }


def members(
    case: Case,
    out: Path,
    *,
    count: int = 8,
    seed: int = 0,
    spread: float | None = None,
    threads: int | None = None,
    force: bool = False,
    pictures: bool = True,
) -> list[Spread]:
    """Run members of a case, whose cells are a little off, and return how much of each number they have in common.

    Parameters
    ----------
    case : Case
        A case of a tissue.
    out : Path
        The folder: one of its own for each member, `members.csv` and `spread.csv`.
    count : int
        Number of members, >= 2.
    seed : int
        Seed of the first, >= 0; the others follow one by one. The same seeds give the same numbers.
    spread : float, optional
        Share of the side by which corners are displaced at most, and of their thickness by which walls deviate, in
        (0, 0.1]; by default 0.001. Where the tissue of the case is drawn from a seed, members have other seeds, and
        differ as it says.
    threads, force, pictures
        As for `ngcell.record`.

    Returns
    -------
    list of Spread
        A row for each level and number; members that are not certified do not count.

    Raises
    ------
    CaseError, OutputError
        If a member cannot be built; if the folder holds other results, or cannot be written.
    """
    options = RecordingOptions(threads, force=force, pictures=pictures)
    ensemble = Ensemble(case, out, MemberChoice(count, seed, spread), options)
    for _ in ensemble:
        pass
    return ensemble.spreads


def ensemble_of(
    case: AnyCase | None, out: Path, choice: Mapping[str, Any], options: Mapping[str, Any]
) -> Ensemble:
    """Return members of a case as the command line asks for them; without a case those that are missing in a folder."""
    how = RecordingOptions(**options)
    return _resumed(out, how) if case is None else Ensemble(case, out, MemberChoice(**choice), how)


def _resumed(out: Path, options: RecordingOptions) -> Ensemble:
    """Return the rest of members that were begun in a folder; it ends with the numbers that a run without stop has.

    Raises
    ------
    OutputError
        If the folder holds no members that have been stopped.
    """
    summary = read_summary(out)
    told, text = summary.get(MEMBERS), summary.get(CASE_TEXT)
    try:
        choice = MemberChoice(**told) if isinstance(told, dict) else None
        restore_case(out, summary)
        case = read_case(Path(out) / "case.toml")
    except (TypeError, CaseError) as error:
        raise cannot_resume(out, str(error)) from error
    if choice is None or not isinstance(text, str) or not isinstance(case, Case):
        raise cannot_resume(out, "it holds no members that were stopped")
    return Ensemble(case, out, choice, options, resumed=True)


def _has_begun(out: Path, case: Case) -> bool:
    """Return whether a folder holds accepted steps of this member, and not those of another run."""
    with suppress(OutputError):
        return _steps_in(out) > 0 and _is_of(out, case)
    return False


def _steps_in(out: Path) -> int:
    """Return the number of accepted steps in the folder of a member."""
    return accepted_steps(out, read_summary(out))


def _is_of(out: Path, case: Case) -> bool:
    file = out / "case.toml"
    return file.is_file() and file.read_text(encoding="utf-8", errors="replace") == resolved_toml(case)


def _member(
    number: int, seed: int, summary: dict[str, Any], history: list[StepRecord], factors: Sequence[float]
) -> Member:
    """Return a member that has ended with a summary."""
    certified, outcome = bool(summary.get("certified")), str(summary.get("outcome"))
    checks = failed_checks(summary)
    if checks and not certified:
        outcome = f"{outcome.partition(';')[0]}: {', '.join(checks)}"
    return Member(number, seed, outcome, certified, at_levels(history, factors))


def _refused(number: int, seed: int, error: CaseError, levels: int, word: str = REFUSED) -> Member:
    """Return a member whose geometry cannot be built."""
    return Member(number, seed, f"{word}: {error}", False, (None,) * levels)


def _out_of_time(ended: int) -> NotConverged:
    outcome = Outcome.OUT_OF_TIME
    return NotConverged(f"after {ended} members: {outcome.value}", outcome=outcome.name)
