"""TIAGo: a two-wheeled base with a lift, an arm of seven joints, and a head that pans and tilts."""
