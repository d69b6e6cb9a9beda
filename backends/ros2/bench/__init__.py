"""A simulated robot that speaks ROS 2, to rehearse what a robot by topics does."""
