"""Path lengths, the matrix T, places from paths, and what scatters or delays the wave on its way.

Method 1 and 3.
"""
