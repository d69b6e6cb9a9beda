"""What stands around the robot in Bullet."""
