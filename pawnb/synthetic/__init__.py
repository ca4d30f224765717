"""Rendered scenes with exact truth: the built-in sample, tests and benchmarks."""
