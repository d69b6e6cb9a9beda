"""Motion of a base by its wheels and inertial sensors, with an honest covariance."""
