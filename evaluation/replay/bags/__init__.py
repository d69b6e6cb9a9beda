"""Reading ROS bags, also damaged ones, as recorded logs."""
