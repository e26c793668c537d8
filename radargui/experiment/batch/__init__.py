"""Batch: many stored runs processed again, on all cores of this computer or on a cluster."""
