"""What lays sensors in Bullet."""
