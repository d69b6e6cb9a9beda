"""The shipped kinds of sensors, one a module."""
