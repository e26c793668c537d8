"""What the channels should show: motion, maps, front end, mirrors, slow noise."""
