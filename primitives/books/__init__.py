"""Books: their catalogue, slots and the primitives that return them to their shelves."""
