"""The solver's own numbers, as records that are handed down.

None of them is meant for a case: a study shows that results hardly depend on them, but for the branch that is found.
Lengths are shares of the longest step of the minimiser, energies and forces shares of what is at stake, weights of the
proximal term multiples of the continuation's scale (`ngcell.solve.continuation`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ngcell.solve.continuation_options import ContinuationOptions


@dataclass(frozen=True)
class CoarseOptions:
    """Numbers of the inner problem among the low modes of bodies.

    Attributes
    ----------
    fewest : int
        Number of bodies from which on it is used: nine cells take as long without it, 35 to 49 a quarter longer.
    modes, first_steps : int
        Modes of a body, and steps of inverse iteration at first; there is one for each model later.
    most_rounds, worthwhile_gain : int, float
        Most rounds among modes, and the share of the decrease so far below which they end.
    """

    fewest: int = 25
    modes: int = 8
    first_steps: int = 3
    most_rounds: int = 30
    worthwhile_gain: float = 0.05


@dataclass(frozen=True)
class InnerOptions:
    """Numbers of the inner piecewise quadratic problem.

    Attributes
    ----------
    most_rounds : int
        Most inner iterations, as the outer iteration judges their step; and factorisations to foreseen multipliers.
    worthwhile_gain, round_off : float
        Shares of the decrease so far: the iteration ends where it gains less, and has not gone up where it loses less.
    least_gain, most_settled : float, int
        The least share that a settled model goes on for, and its most rounds.
    lost : float
        Factor by which corrections of an inverse may enlarge round-off.
    most_updates : int
        Most steps to multipliers that are foreseen, each at the price of a solution.
    coarse : CoarseOptions
        Those of the problem among low modes of bodies.
    """

    most_rounds: int = 8
    worthwhile_gain: float = 0.3
    round_off: float = 1e-9
    least_gain: float = 0.01
    most_settled: int = 40
    lost: float = 1e6
    most_updates: int = 100
    coarse: CoarseOptions = CoarseOptions()

    def within(self, misfit: float) -> InnerOptions:
        """Return the numbers for a model that is as good as the one before, which was off by a share of its decrease.

        Rounds that gain less than that share of the decrease are not worth while, those that gain more are (Eisenstat
        and Walker, SIAM J. Sci. Comput. 17, 1996, doi:10.1137/0917003). Never fewer are made than of any model.
        """
        if not misfit < self.worthwhile_gain:
            return self
        gain = min(max(misfit, self.least_gain), self.worthwhile_gain)
        return replace(self, worthwhile_gain=gain, most_rounds=self.most_settled)


@dataclass(frozen=True)
class MinimiserOptions:
    """Numbers of the damped Newton method.

    Attributes
    ----------
    poor, fair : float
        Share of the foreseen decrease below which a step is refused, and above which the damping falls.
    straight : float
        Multiple of the foreseen decrease above which the energy falls nearly straight on, and longer steps are tried:
        half-way from a curvature as foreseen, 1, to none at all, 2.
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
    last_digit, cheap, cheap_at_last : float, float, float
        Length to which places on the way are rounded, as a share of the longest step, and the share of what a step
        gains that this may cost, with an accuracy and without: the path then goes to the last digits.
    sure : float
        Factor of a decrement that is foreseen from the forces left: those found were up to six times as large.
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
    straight: float = 1.5
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
    last_digit: float = 1e-5
    cheap: float = 0.01
    cheap_at_last: float = 0.001
    sure: float = 10.0
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
class StabilityOptions:
    """Numbers of the search for directions in which the energy falls.

    Attributes
    ----------
    near, farther, most_weights : float, float, int
        Weight of the mass matrix, in units of the continuation's scale, added to the tangent: the eigenvalues next to
        zero stand apart with it, and take few rounds. Where one is below minus that, the next weight is so many times
        as large as it is low, until none is, or so many have been tried.
    rounds, settled : int, float
        Most rounds of Lanczos' method, and the residual of a Ritz pair, as a share of its value, at which it ends.
    as_low, most_modes, unmixed : float, int, float
        Share of the lowest curvature down to which a saddle is left along other modes too, how many of them at most,
        and the accuracy of their values as a share.
    negative : float
        Multiple of the scale down to which a negative curvature is none: a thousandth of `near`, beside which the
        residual of a Ritz pair leaves its value off by `settled` squared, 1e-8 of the scale.
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
    farther: float = 4.0
    most_weights: int = 8
    rounds: int = 40
    settled: float = 1e-3
    as_low: float = 0.9
    most_modes: int = 3
    unmixed: float = 1e-6
    negative: float = 1e-5
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
        That ratio for states from a coarser mesh of what is beyond `direct_bulk`: they change their volume on the finer
        one.
    handed_on : float
        Decrement of a minimisation on a finer mesh from which a stiffer one, or multipliers, go on, as a share of the
        energy.
    most_work, work_of_body : int
        Factorisations and refused trial steps of a step, all attempts together: for any scene, and more for each body.
        Iterations would bound no time, since some take a hundred of them.
    work_of_mesh : int
        Times of that work which a step may take to go on to a finer mesh, where it is known to be: what a coarse mesh
        has held up may fall a long way there.
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
    work_of_mesh: int = 3

    def work_of(self, bodies: int) -> int:
        """Return what a step with so many bodies may take."""
        return self.most_work + self.work_of_body * bodies
