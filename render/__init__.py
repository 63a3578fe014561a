"""Pictures: shapes off-screen with pyvista, curves with matplotlib."""
