"""Simulated CiA 402 drives, alone or in front of a simulated robot."""
