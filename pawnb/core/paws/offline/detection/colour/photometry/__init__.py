"""Colour and light of the pictures, before and beside the colour model.

Comes in: pictures and where the clicks are. Goes out: pictures as bright as at the clicks
(``illumination``), the scene without the animal (``background``), bins of fine steps of colour
(``colour_quantisation``) and how thick paws are (``paw_width``).
"""
