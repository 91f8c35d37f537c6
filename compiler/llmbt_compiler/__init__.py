"""From a request and a semantic map to an initial behaviour tree of goal conditions."""
