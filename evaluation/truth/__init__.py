"""Whether outcomes are true, by the ground truth of a simulated world."""
