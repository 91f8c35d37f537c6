"""What passes between the compiler and the runtime: conditions, trees, maps, scenes, diagnostics, versions."""
