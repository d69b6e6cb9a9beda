"""The robot in MuJoCo: its URDF, its bodies, its joints."""
