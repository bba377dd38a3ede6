"""The workers: jobs, pictures, and the process that runs them."""
