"""Minimum-distortion correspondence between non-rigid shapes: the numerics, and nothing else.

After Wang, Bronstein and Paragios, "Discrete minimum distortion correspondence problems for
non-rigid shape matching", INRIA RR-7333, 2010. Equation and section numbers in this package are
that paper's unless another source is named.
"""
