"""Operations of the API without I/O, shared by both clients: requests and their answers.

An operation is a generator that yields calls and returns a value, see
:mod:`isomatch._http.operation`. There is a module for each kind of resource.
"""
