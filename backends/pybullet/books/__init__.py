"""Books in Bullet."""
