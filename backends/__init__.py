"""What a robot is: capabilities, Robot, and the backends behind it."""
