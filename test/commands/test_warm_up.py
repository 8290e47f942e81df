from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE
from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands.warm_up import variants


def test_warm_up_reports_that_the_loops_are_compiled(command):
    result = command("warm-up")
    assert result.code == 0
    assert "the inner loops are compiled" in result.out


def test_every_word_that_a_parameter_may_have_comes():
    every = [parameters.as_mapping() for parameters in variants(PRESETS.values())]
    for spec in PARAMETER_TABLE:
        assert {values[spec.name] for values in every} >= set(spec.choices)
    filters = {(values["filter"], values["observation"]) for values in every}
    assert ("bootstrap", "likelihood_ratio") in filters


def test_none_comes_twice_of_one_preset():
    preset = PRESETS["thesis"]
    every = list(variants([preset]))
    assert every.count(preset) == 1
    assert len(every) == len(set(every))
