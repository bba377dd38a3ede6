"""The process of a worker: settings, warm-up, the loop, the health check, RQ's entry points.

Its modules are started by name, and some must start without loading the numerics: nothing is
imported here.
"""
