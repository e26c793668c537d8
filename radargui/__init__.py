"""RadarGUI: record a particle-tracking radar, watch it live, measure the restitution of a falling sphere."""

__version__ = "0.1.0"
