"""Interface of a physics engine, and the bodies and surfaces that it is given."""
