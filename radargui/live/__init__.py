"""Follow the tracer live: trigger, fall test, filter, place, and what speaks against the place.

Method 2, Live.
"""
