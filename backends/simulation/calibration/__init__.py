"""Marks on tables of simulated worlds, with which cameras are calibrated."""
