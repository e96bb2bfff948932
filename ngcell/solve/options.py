"""The solver's own numbers, as records that are handed down.

None of them is meant for a case: a study shows that results do not depend on them. Lengths are shares of the longest
step of the minimiser, energies and forces shares of what is at stake, weights of the proximal term multiples of the
continuation's scale (`ngcell.solve.continuation`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class InnerOptions:
    """Numbers of the inner piecewise quadratic problem.

    Attributes
    ----------
    most_rounds : int
        Most inner iterations, as the outer iteration judges their step; and factorisations to foreseen multipliers.
    worthwhile_gain, round_off : float
        Shares of the decrease so far: the iteration ends where it gains less, and has not gone up where it loses less.
    lost : float
        Factor by which corrections of an inverse may enlarge round-off.
    most_updates : int
        Most steps to multipliers that are foreseen, each at the price of a solution.
    """

    most_rounds: int = 8
    worthwhile_gain: float = 0.3
    round_off: float = 1e-9
    lost: float = 1e6
    most_updates: int = 100


@dataclass(frozen=True)
class MinimiserOptions:
    """Numbers of the damped Newton method.

    Attributes
    ----------
    poor, fair : float
        Share of the foreseen decrease below which a step is refused, and above which the damping falls.
    raise_by, nudge_by, lower_by : float
        Factors of the damping after a refused, a poor and a good step.
    short : float
        Share of a step below which it is not cut to the longest step, but damped in the bodies that go too far.
    local, worthwhile : float, float
        Share of the coupled bodies below which a model that is not convex is at fault in few places only, and so many
        bodies' mean share of the decrease that is worth an inner iteration, if that is less than the inner problem's.
    felt, unfelt : float
        Shares of a step's slope at which damping is felt along the step, and at which it is not.
    round_off, no_decrement : float
        Differences of energies below this share of the energy are round-off; so are such decrements.
    stalled, unseen, idle : float, float, int
        A decrement below the share `stalled` of the energy, or below `unseen` times its round-off at rest, is lost once
        as many iterations as `idle` left it at its lowest: forces are round-off, or steps go to and fro at a kink of
        the energy, as where walls end at a corner of three cells. As many iterations whose steps were refused at first,
        and that gained less together than the minimisation is to be exact, creep along such a kink.
    touching, noise : float, float
        Gap below which a prediction keeps walls closed; and round-off of an energy at rest as a share of the scale.
    most_refusals, most_iterations : int
        Limits of one step, and of one minimisation: where rows of cells slide past others, it takes some hundreds.
    near : float
        Gap up to which a new matrix has room for open walls, as a share of the longest step; 0.03 to 0.3 take as long.
    most_direct, narrow : int, float
        Unknowns and width of bodies up to either of which solids are factorised in one piece; planar scenes always are.
    inner, foreseeing : InnerOptions
        Those of the inner problem, and of one that nothing judges afterwards, which ends when walls have settled.
    """

    poor: float = 1e-4
    fair: float = 0.25
    raise_by: float = 8.0
    nudge_by: float = 2.0
    lower_by: float = 0.1
    short: float = 0.1
    local: float = 0.5
    worthwhile: float = 10.5
    felt: float = 0.1
    unfelt: float = 1e-4
    round_off: float = 1e-13
    no_decrement: float = 1e-18
    stalled: float = 1e-12
    unseen: float = 10.0
    idle: int = 5
    touching: float = 1e-6
    noise: float = 1e-16
    most_refusals: int = 25
    most_iterations: int = 1000
    near: float = 0.1
    most_direct: int = 200_000
    narrow: float = 200.0
    inner: InnerOptions = field(default_factory=InnerOptions)
    foreseeing: InnerOptions = InnerOptions(most_rounds=50, worthwhile_gain=0.0)


@dataclass(frozen=True)
class ContinuationOptions:
    """Numbers of the continuation in the weight of the proximal term.

    Attributes
    ----------
    first, enough, last : float
        Weight at the start, where the continuation may end if need be, and at its end, where the centre stays.
    felt, felt_of_accuracy : float
        Pull of the proximal term on a body that is felt, as a share of the largest force on one; and that over the
        accuracy that is asked for: half of what the certificate allows.
    sufficient, sufficient_of_accuracy : float
        By how much the energy may still fall, as a share of itself, when no further centre is taken, 0 where the centre
        stays; and that over the accuracy that is asked for.
    recentred, resting, most_recentred, idle, idle_at_last, refined : float, float, int, float, float, float
        Weight at which the proximal term begins to hold bodies where they are; that under which last digits are found,
        which is no less; the most centres; the share of a fall above which the next one is slow, and the weight is
        lowered; that share once falls suffice and only the pull is felt; and the decrement of the last minimisation as
        a share of the energy: 1e-12 left forces 2.9e-6 out of balance, and does not tell which cells nothing holds.
    allowed, allowed_of_accuracy, nearly_allowed : float, float, float
        Pull that is allowed in a result, as a share of the largest force on a body; that over the accuracy that is
        asked for, nine tenths of what the certificate allows; and the multiple of it up to which another centre under
        the same weight may do.
    only_leads : bool
        Whether the end of the path only leads to equilibria on finer meshes.
    handover, handover_idle : float
        Weight from which multipliers take over from a penalty: without its overlaps walls slide on, far for little
        energy; and `idle_at_last` there.
    slid, most_leads : float, int
        Falls that suffice from which on they have slid away, and the penalty, which may cost half of it, leads again.
    hardly_strained : float
        Strain below which the energy is told from nothing no more.
    first_overlapping : float
        Weight at the start where walls overlap at rest: a larger one would hold them deep in each other, where the
        nearest wall changes from point to point and the energy is not smooth.
    narrowest, widest, last_digit : float
        Decades by which the weight falls from one minimisation to the next, at least and at most; and the length to
        which the place is rounded where a continuation begins.
    stiffen_at : float
        Weight at which contact stiffens: walls have found their contact pairs there, and floating cells are still held
        well enough to follow.
    on_the_way, at_the_end : float
        Decrement at which a minimisation on the way, and the last one, ends: shares of the proximal energy.
    update : float
        Decrement at which a minimisation between multiplier updates ends: share of the energy of missed conditions.
    condition, most_updates, foreseen : float, int, float
        Length by which conditions may be missed at the end, the most updates to get there, and the share of missed
        conditions that multipliers which are foreseen may leave in their model.
    cycling : int
        Iterations of one minimisation that are active-set cycling, on the last stretch and between multiplier updates.
    slow, nothing : float
        Share of what was missed before above which an update was slow; and that of the energy that is nothing: a
        decrement on the way, or what is missed where updates hardly help, as slivers of walls bear nothing.
    farthest, hold_back : float
        Longest way of a predicted centre, in longest steps or ways of the supports, and the factor of the weight that
        holds back what would go further.
    """

    first: float = 1e3
    enough: float = 1e-7
    last: float = 1e-9
    felt: float = 0.0
    felt_of_accuracy: float = 0.05
    sufficient: float = 0.0
    sufficient_of_accuracy: float = 0.05
    recentred: float = 1e-4
    resting: float = 1e-3
    most_recentred: int = 30
    idle: float = 0.9
    idle_at_last: float = 0.9
    refined: float = 1e-16
    allowed: float = 0.0
    allowed_of_accuracy: float = 0.09
    nearly_allowed: float = 2.0
    only_leads: bool = False
    handover: float = 3e-3
    handover_idle: float = 0.7
    slid: float = 10.0
    most_leads: int = 10
    hardly_strained: float = 1e-5
    first_overlapping: float = 1.0
    narrowest: float = 0.5
    widest: float = 1.0
    last_digit: float = 1e-6
    stiffen_at: float = 1e-5
    on_the_way: float = 0.01
    at_the_end: float = 1e-12
    update: float = 0.1
    condition: float = 1e-12
    most_updates: int = 40
    foreseen: float = 1e-5
    cycling: int = 200
    slow: float = 0.1
    nothing: float = 1e-11
    farthest: float = 2.0
    hold_back: float = 100.0

    def within(self, accuracy: float) -> ContinuationOptions:
        """Return the numbers with which results have this relative error."""
        felt, sufficient = self.felt_of_accuracy * accuracy, self.sufficient_of_accuracy * accuracy
        allowed, resting = self.allowed_of_accuracy * accuracy, max(self.resting, self.recentred)
        return replace(self, felt=felt, allowed=allowed, sufficient=sufficient, resting=resting)

    @property
    def end(self) -> float:
        """Weight at which the path from one centre ends."""
        return self.recentred if self.sufficient else self.last


@dataclass(frozen=True)
class StabilityOptions:
    """Numbers of the search for directions in which the energy falls.

    Attributes
    ----------
    near, far : float
        Weights of the mass matrix, in units of the continuation's scale, added to the tangent. With the first one the
        eigenvalues next to zero stand apart and take few rounds; where one is negative, the second, large beside
        negative curvatures, finds the lowest.
    rounds, settled : int, float
        Most rounds of Lanczos' method, and the residual of a Ritz pair, as a share of its value, at which it ends.
    negative : float
        Multiple of the scale down to which a negative curvature is none.
    lost : float
        Share of the largest Ritz value below which a negative one is round-off.
    departures : tuple of float
        Distances from a saddle that are tried, as shares of the longest step.
    fallen, same : float
        Shares of the energy by which it has to fall, and below which two minima are as low.
    most_saddles : int
        Most saddles that are left one after the other.
    """

    near: float = 0.01
    far: float = 10.0
    rounds: int = 40
    settled: float = 1e-3
    negative: float = 1e-3
    lost: float = 1e-9
    departures: tuple[float, ...] = (0.5, 0.05, 0.005)
    fallen: float = 1e-9
    same: float = 1e-6
    most_saddles: int = 10


@dataclass(frozen=True)
class LoadSteppingOptions:
    """Numbers of load stepping with a history.

    Attributes
    ----------
    mismatch, longer : float
        Largest mismatch of a step, as a share of the energy that it moves, and below which the next step may be longer.
    quiet : float
        Share of all energy so far that counts as moved even where less is.
    snapped : float
        Share of the energy moved that the forces at both ends leave unexplained and above which walls have snapped.
    farthest : float
        Longest way of the bodies along the straight line, in longest steps or ways of the supports.
    """

    mismatch: float = 1e-3
    longer: float = 2e-4
    quiet: float = 1e-4
    snapped: float = 0.1
    farthest: float = 2.0


@dataclass(frozen=True)
class SolverOptions:
    """All of the solver's own numbers.

    Attributes
    ----------
    minimiser, continuation, load_stepping, stability
        Those of each method.
    direct_bulk, bulk_stage : float
        Ratio of bulk to shear modulus up to which a law is followed as it is, and the factor between the stages beyond
        it: there Newton's method crawls along the curved valley of constant volume.
    transferred_bulk : float
        That ratio for states from a coarser mesh, which change their volume on the finer one.
    handed_on : float
        Decrement of a minimisation on a finer mesh from which a stiffer one, or multipliers, go on, as a share of the
        energy.
    most_work, work_of_body : int
        Factorisations and refused trial steps of a step, all attempts together: for any scene, and more for each body.
        Iterations would bound no time, since some take a hundred of them.
    """

    minimiser: MinimiserOptions = field(default_factory=MinimiserOptions)
    continuation: ContinuationOptions = field(default_factory=ContinuationOptions)
    load_stepping: LoadSteppingOptions = field(default_factory=LoadSteppingOptions)
    stability: StabilityOptions = field(default_factory=StabilityOptions)
    direct_bulk: float = 1e4
    bulk_stage: float = 30.0
    transferred_bulk: float = 100.0
    handed_on: float = 1e-8
    most_work: int = 3000
    work_of_body: int = 30

    def work_of(self, bodies: int) -> int:
        """Return what a step with so many bodies may take."""
        return self.most_work + self.work_of_body * bodies
