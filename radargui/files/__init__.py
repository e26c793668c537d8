"""What is kept on disk and read from it: run files, CSV, MATLAB, TDMS, SigMF."""
