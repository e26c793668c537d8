"""What helps at the first start: steps that tick themselves off, and what to do where a plot is empty."""
