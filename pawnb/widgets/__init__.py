"""Thin faces over the workflow, for notebooks."""
