"""Exception for a part of the kit that cannot run on a robot."""


class Skipped(Exception):
    """Exception of a check that cannot be made on this robot; the message gives the reason."""
