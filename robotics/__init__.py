"""The mathematics: arrays in, arrays or named tuples out; no I/O, no framework."""
