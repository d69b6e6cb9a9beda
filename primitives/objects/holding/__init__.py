"""Postures and motions of an arm that grasps, carries, puts down and offers an object."""
