"""Numbers of the continuation in the weight of the proximal term, and of what follows its end.

Lengths are shares of the longest step of the minimiser, weights multiples of the continuation's scale
(`ngcell.solve.continuation`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace


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
    sufficient_to_lead, at_path_end : float
        The least that suffices at the end of a path that only leads to finer meshes: a quarter of what tied tissues err
        by on its mesh, an eighth of what released ones do; and what suffices at the end of this one.
    recentred, resting, most_recentred, idle, idle_at_last : float, float, int, float, float
        Weight at which the proximal term begins to hold bodies where they are; that under which last digits are found,
        which is no less; the most centres; the share of a fall above which the next one is slow, and the weight is
        lowered; and that share once falls suffice and only the pull is felt.
    refined, leading, unmet : float, float, float
        Decrement of the last minimisation as a share of the energy: 1e-12 left forces 2.9e-6 out of balance, and does
        not tell which cells nothing holds; and the shares of what suffices whose square it is on meshes that only lead,
        and before multipliers are updated to the end: with a decrement fifty times as large walls slide during updates.
    unbalanced : float
        Share of the forces in bodies that may be left out of balance in the end: half of what a certificate allows.
    allowed, allowed_of_accuracy : float, float
        Pull that is allowed in a result, as a share of the largest force on a body; and that over the accuracy that is
        asked for, nine tenths of what the certificate allows.
    allowed_to_lead, most_led, led_at_most : float, int, float
        The most that is allowed on a mesh that only leads to finer ones; how often as many iterations as the path took
        may follow walls there; and the share of the work of a step from which on they do not.
    only_leads : bool
        Whether the end of the path only leads to equilibria on finer meshes.
    handover, handover_update, handover_idle : float, float, float
        Weight under which multipliers take over from a penalty, in units of that under which last digits are found, and
        `update` and `idle_at_last` there: without its overlaps walls slide on, far for little energy.
    slid, most_leads : float, int
        Falls that suffice from which on they have slid away, and the penalty, which may cost half of it, leads again;
        half as many where a coarser mesh leads instead.
    undone, most_in_vain : float, int
        Share of an overlap that penalty terms which were made ten times stiffer may leave, half-way, in logarithms,
        from the tenth where walls press to all of it; and how often in a row they may leave more until walls are
        presumed to be on wrong sides of each other.
    hardly_strained : float
        Strain below which the energy is told from nothing no more.
    first_overlapping : float
        Weight at the start where walls overlap at rest: a larger one would hold them deep in each other, where the
        nearest wall changes from point to point and the energy is not smooth.
    narrowest, widest : float
        Decades by which the weight falls from one minimisation to the next, at least and at most.
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
    missed_work : float
        Work of contact pressures on missed lengths, as a share of the energy, a tenth of what the certificate allows.
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
    sufficient_to_lead: float = 0.02
    at_path_end: float = 0.0
    recentred: float = 1e-4
    resting: float = 1e-3
    most_recentred: int = 30
    idle: float = 0.9
    idle_at_last: float = 0.9
    refined: float = 1e-16
    leading: float = 0.02
    unmet: float = 0.2
    unbalanced: float = 5e-7
    allowed: float = 0.0
    allowed_of_accuracy: float = 0.09
    allowed_to_lead: float = 1e-3
    most_led: int = 10
    led_at_most: float = 0.5
    only_leads: bool = False
    handover: float = 3.0
    handover_update: float = 0.01
    handover_idle: float = 0.7
    slid: float = 10.0
    most_leads: int = 10
    undone: float = 1 / 3
    most_in_vain: int = 2
    hardly_strained: float = 1e-5
    first_overlapping: float = 1.0
    narrowest: float = 0.5
    widest: float = 1.0
    stiffen_at: float = 1e-5
    on_the_way: float = 0.01
    at_the_end: float = 1e-12
    update: float = 0.1
    condition: float = 1e-12
    most_updates: int = 40
    foreseen: float = 1e-3
    missed_work: float = 1e-7
    cycling: int = 500
    slow: float = 0.1
    nothing: float = 1e-11
    farthest: float = 2.0
    hold_back: float = 100.0

    def within(self, accuracy: float) -> ContinuationOptions:
        """Return the numbers with which results have this relative error."""
        felt, sufficient = self.felt_of_accuracy * accuracy, self.sufficient_of_accuracy * accuracy
        at_path_end = max(sufficient, self.sufficient_to_lead) if self.only_leads else sufficient
        ends = replace(self, felt=felt, sufficient=sufficient, at_path_end=at_path_end)
        allowed, resting = self.allowed_of_accuracy * accuracy, max(self.resting, self.recentred)
        return replace(ends, allowed=allowed, resting=resting)

    @property
    def handing_over(self) -> ContinuationOptions:
        """The numbers with which multipliers take over from a penalty: walls are held so that they stay at its
        equilibrium, or slide on in small steps."""
        weights = replace(self, recentred=self.handover * self.resting, last=self.recentred)
        return replace(weights, update=self.handover_update, idle_at_last=self.handover_idle)

    @property
    def of_leading(self) -> float:
        """Decrement of the last minimisation on a mesh that only leads to finer ones, as a share of the energy."""
        return max((self.leading * self.sufficient) ** 2, self.refined)

    @property
    def before_multipliers(self) -> float:
        """Decrement of a minimisation before multipliers are updated to the end, as a share of the energy."""
        return max((self.unmet * self.sufficient) ** 2, self.refined)

    @property
    def end(self) -> float:
        """Weight at which the path from one centre ends."""
        return self.recentred if self.sufficient else self.last
