"""Estimate motion and mismatch from all channels together: flights, circles with maps, the joint estimate.

Method 4.
"""
