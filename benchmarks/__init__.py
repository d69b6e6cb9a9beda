"""Measurements of speed, accuracy and truth; `python -m benchmarks` lists them."""
