"""The adaptive correction: each receiver's circle has a centre and a radius that depend on the position.

Method 2, adaptive.
"""
