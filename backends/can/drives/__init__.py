"""CiA 402 drives, as the robot commands them."""
