"""Building a map from scans and odometry: scan matching, loop closures, a pose graph, a picture of cells."""
