"""Every set of measured recordings in ../shared/data: diagnosis, one table."""
