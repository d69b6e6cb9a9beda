"""Judge the outcomes of a run by the ground truth of a simulated world."""
