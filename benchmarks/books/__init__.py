"""Returning books, measured."""
