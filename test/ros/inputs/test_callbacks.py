from cable_tracker.ros.inputs.callbacks import followed_by


def test_the_message_is_taken_before_the_news_is_told():
    calls = []
    followed_by(calls.append, lambda: calls.append("news"))("message")
    assert calls == ["message", "news"]
