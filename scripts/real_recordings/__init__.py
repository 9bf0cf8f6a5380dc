"""Every set of measured recordings in ../shared/data: robot files, runs, diagnosis, one table."""
