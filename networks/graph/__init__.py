"""The action network, planning over it, and where a run stands in it."""
