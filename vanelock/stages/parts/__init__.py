"""Steps to meshes, matrices and reduced parts."""
