"""The backend with physics, on MuJoCo."""
