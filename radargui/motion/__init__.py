"""Free flights, and the impacts and sharp minima of a height.

Method 5, Flights and Impacts.
"""
