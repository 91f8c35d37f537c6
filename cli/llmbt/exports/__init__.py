"""Trees in the forms that other programs read: pictures, graphs, logs, and code to run them with."""
