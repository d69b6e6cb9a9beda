"""The action network, planning over it, and a run's route through it."""
