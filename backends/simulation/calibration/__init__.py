"""Marks on tables of simulated worlds, for cameras."""
