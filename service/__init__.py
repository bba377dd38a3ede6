"""The HTTP API: it takes requests, queues jobs and serves results, and computes nothing itself."""
