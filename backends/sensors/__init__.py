"""Kinds of sensors: what each of them is made of, by the name in a robot's file."""
