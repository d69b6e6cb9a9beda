"""Three-dimensional view of a run in the browser, recorded or live."""
