"""Sessions: folders of runs with their record, found again later."""
