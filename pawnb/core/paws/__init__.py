"""Points tracked through one view or more: paws, and landmarks of the body.

A ``request`` says which points, frames and views; every tracker takes it with opened views and
annotations, and returns Tracks. ``offline`` is the default: it decides over the whole recording.
``maghsoudi2019`` is the published system, frame by frame. ``start_proposal`` finds the first
annotations without a click.
"""
