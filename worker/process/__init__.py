"""The worker process: warm-up, main loop, health check.

The modules are started by name, and the health check must not load the numerics: nothing is
imported here.
"""
