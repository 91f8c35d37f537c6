"""Any BehaviorTree.CPP 4 file: a lossless model of it, the linter, and how two files are matched to be compared."""
