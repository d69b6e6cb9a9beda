"""The robot of Hatano et al. (2000), on a suspension."""
