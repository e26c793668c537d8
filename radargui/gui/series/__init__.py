"""The series: statistics, e against the impact speed, falls over one parabola, of one session or several."""
