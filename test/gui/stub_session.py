"""A session without a recording or a node: a test tells its snapshots."""

from cable_tracker.gui.session.session import Session
from cable_tracker.gui.subject import CABLE


class StubSession(Session):
    """Takes every command, and changes nothing by it."""

    name = "/boat/tracker"
    subject = CABLE
    table = ()
    trouble = ""
    is_enabled = True

    def tell(self, snapshot):
        self._publish(snapshot)

    def parameters(self):
        return {}

    def change(self, values):
        pass

    def initialise(self, start):
        pass

    def reset(self):
        pass

    def enable(self, wanted):
        pass

    def close(self):
        pass
