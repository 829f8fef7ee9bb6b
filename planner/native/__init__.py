"""The compiled inner loops: kinematics, distances, proofs of motions, detours, flows. C++ in ``source``, its door here.

A plain shared library with C functions, so that one build serves every Python; ``hatch_build.py`` makes it when the
package is installed. Sums are added in one order and nothing is fused, so that every compiler and processor gives the
same bits, on one thread or many.
"""
