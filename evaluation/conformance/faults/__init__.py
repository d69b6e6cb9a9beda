"""Injected faults, and the check that outcomes stay true."""
