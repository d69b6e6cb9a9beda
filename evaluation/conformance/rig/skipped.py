"""Why a part of the kit isn't tried."""


class Skipped(Exception):
    """The check can't be made on this robot."""
