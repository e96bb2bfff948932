"""A script hands a strategy over: its smallest number of steps counts as that of a case does."""

import ngcell

PRESS_FIT = ngcell.read_case("press-fit", ["accuracy=inf"])


def test_the_steps_of_a_strategy_that_a_script_hands_over_are_taken():
    steps = ngcell.simulate(PRESS_FIT, strategy=ngcell.SingleStep(steps=3))
    assert [round(step.record.load_factor, 12) for step in steps] == [round(n / 3, 12) for n in (1, 2, 3)]


def test_without_steps_of_its_own_a_strategy_takes_those_of_the_scene():
    assert len(ngcell.simulate(PRESS_FIT, strategy=ngcell.SingleStep())) == len(ngcell.simulate(PRESS_FIT))
