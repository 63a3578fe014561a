"""Contact faces: patches, the areas that belong to nodes, normal directions."""
