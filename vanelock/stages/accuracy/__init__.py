"""An accuracy turned into meshes, reductions and error estimates."""
