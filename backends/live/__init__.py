"""What real robots have in common: the clock of the control loop, and sensors that send by themselves."""
