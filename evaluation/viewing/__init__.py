"""Reports, pictures, playback, explanations and the view of runs."""
