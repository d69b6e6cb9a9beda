"""The robot in Bullet."""
