"""Start, stop, record: state, worker, health."""
