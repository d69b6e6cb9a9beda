"""Fetch: two driven wheels, a lift, an arm of seven joints, and a head that pans and tilts."""
