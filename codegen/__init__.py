"""Files generated from the declarations of parameters and structures: ``python -m codegen``.

Declared by hand are the options and structures of the solver (fields of ``ParameterSet``) and the
parameters that the service adds (``broker/contracts/parameters.py``). From these follow, in this
order: the contracts of the solver's options, the OpenAPI document, the client's types, the options
of the command line, the fields of the page's form, and tables of the documents. The blocking
client is the asynchronous one without its keywords.
"""
