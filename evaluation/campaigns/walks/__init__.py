"""Random walks through an action network without a robot; thousands in parallel, with drawn outcomes."""
