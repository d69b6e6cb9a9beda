"""Kinds of arms."""
