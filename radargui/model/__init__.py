"""Values with units, settings and errors, which every other package uses.

Symbols of the method are listed in docs/symbols.md.
"""
