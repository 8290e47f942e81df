from cable_tracker.target.parameters.presets import TARGET_PRESETS, target_preset


def test_every_preset_can_be_had_by_its_name():
    assert set(TARGET_PRESETS) == {"default", "thesis", "docking", "diver"}
    assert target_preset("thesis").particle_count == 50
