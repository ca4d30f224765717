"""The pose of a jointed animal, seen by one camera or two: every joint in every frame.

Comes in: opened views, a pose in one frame or more, the species. Goes out: Tracks of joints with
standard deviations. ``fit`` is the default, analysis by synthesis over the whole recording;
``pullar2009`` is the published system (Pullar 2009, chapter 3); ``space`` adds a second view;
``start_proposal`` finds a first pose without a click. ``tracker`` names both methods.
"""
