"""Baseline JPEG pictures, of which any part can be decoded by itself.

Comes in: the bytes of a coded picture. Goes out: the samples of a part, the same as FFmpeg decodes.
ITU-T T.81: where each unit of blocks begins is found once; Huffman decoding and the inverse cosine
transform are of those units only that are asked for.
"""
