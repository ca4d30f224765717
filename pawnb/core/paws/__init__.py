"""Points tracked through one view or more: paws, and landmarks of the body.

Comes in: opened views, annotations, and a ``request`` that says which points, frames and views.
Goes out: Tracks. ``tracker`` has the protocol and the registry of methods. ``offline`` is the
default: it decides over the whole recording. ``maghsoudi2019`` is the published system, frame by
frame. ``start_proposal`` finds the first annotations without a click.
"""
