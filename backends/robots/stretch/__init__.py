"""Stretch: two driven wheels, a lift, an arm that extends sideways, and a head that pans and tilts."""
