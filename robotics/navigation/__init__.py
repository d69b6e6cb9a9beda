"""Maps, Voronoi graphs, tracking, localisation."""
