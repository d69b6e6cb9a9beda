"""What a primitive raises when the world isn't as its model says."""


class Discrepancy(Exception):
    """The motion can't go on as it is: the framework restores, measures, and reports Fail (or GiveUp).

    Attributes:
        reason: in words that a person understands.
        permanent: trying again makes no sense; the action's attempts are used up.
    """

    def __init__(self, reason: str, permanent: bool = False) -> None:
        super().__init__(reason)
        self.reason = reason
        self.permanent = permanent


class NeedsPerson(Exception):
    """Only a person can help: the robot stops where it is and gives up."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason
