"""Cases in processes of their own, several at once: on this machine or on a Dask cluster."""
