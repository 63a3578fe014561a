"""What is refused before meshing, and how good a mesh is."""
