"""Process many stored runs again, on all cores of this computer or on a cluster."""
