"""Engines that tick behaviour trees as BehaviorTree.CPP 4 does: a naive one, and one whose tick costs what changed."""
