"""PR2: a base that drives in any direction, a lift, two arms, and a head that pans and tilts."""
