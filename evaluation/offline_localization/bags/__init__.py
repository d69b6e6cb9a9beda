"""Reading of ROS bags, including damaged ones, as recorded logs."""
