"""The live track: trigger, fall test, filter, place, doubts."""
