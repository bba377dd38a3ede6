"""What runs behind the queue: jobs, the store they share with the API, and the worker process."""
