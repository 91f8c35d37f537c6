"""From a point cloud to a semantic map: pure stages, one a module, put together in `recognise`."""
