"""Preconditions of primitives, declared by their classes and checked before anything moves."""
