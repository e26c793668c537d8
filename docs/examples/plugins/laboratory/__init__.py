"""What one laboratory adds to RadarGUI."""
