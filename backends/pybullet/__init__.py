"""The backend with physics, on Bullet."""
