"""Read and write what is kept on disk: run files, CSV, MATLAB, TDMS, SigMF."""
